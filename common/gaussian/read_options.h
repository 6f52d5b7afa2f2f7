// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace livegs {

// Options for reading a file.
struct ReadOptions {
  // A .ply stores logarithms of standard deviations and logits of opacities. Some exports store the standard
  // deviations and opacities themselves ("activated"), and nothing in the file states this.
  enum class Activated {
    Auto,  // activated if the values are invalid otherwise; a note reports this, or that it is likely
    Yes,   // each property whose values allow it is activated
    No
  };
  Activated activated = Activated::Auto;
};

}  // namespace livegs
