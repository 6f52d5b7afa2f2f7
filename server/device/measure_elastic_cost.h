// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>

#include "compute/backend.h"
#include "core/result.h"
#include "device/elastic_cost.h"

namespace livegs {

// Fits the model by ticks of blocks of different size and steps on `backend` and on this thread; takes a few
// seconds at most. Errors: of the backend.
Result<ElasticCost> measure_elastic_cost(Backend& backend);

// The model in FOLDER/elastic-cost.txt, if it is that of `device` (its name); otherwise measures it and
// writes the file. A file that cannot be read is replaced; one that cannot be written is logged.
Result<ElasticCost> known_elastic_cost(Backend& backend, const std::string& device,
                                       const std::filesystem::path& folder);

}  // namespace livegs
