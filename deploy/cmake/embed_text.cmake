# SPDX-License-Identifier: Apache-2.0
# cmake -DINPUT=file -DOUTPUT=file.h -DNAME=kName -P embed_text.cmake: writes a text file as a C++ string constant.
file(READ "${INPUT}" text)
file(WRITE "${OUTPUT}" "#pragma once\ninline constexpr char ${NAME}[] = R\"livegs_text(${text})livegs_text\";\n")
