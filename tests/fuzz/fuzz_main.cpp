// SPDX-License-Identifier: Apache-2.0
// Entry points of libFuzzer, which defines main(). Seeds are written to the first folder on the command line,
// the corpus.
#include <filesystem>
#include <fstream>
#include <string>

#include "fuzz/fuzz_target.h"

using namespace livegs::fuzz;

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  for (int i = 1; i < *argc; ++i) {
    const std::filesystem::path folder = (*argv)[i];
    if (!std::filesystem::is_directory(folder)) continue;
    int number = 0;
    for (const Bytes& seed : targets().at(0).seeds()) {
      std::ofstream(folder / ("seed-" + std::to_string(number++)), std::ios::binary)
          .write(reinterpret_cast<const char*>(seed.data()), static_cast<std::streamsize>(seed.size()));
    }
    break;
  }
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  targets().at(0).look_at(std::as_bytes(std::span(data, size)));
  return 0;
}
