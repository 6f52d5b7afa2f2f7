// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/chart/chart_scenes.h"

#include "study/elastic_scenes/cantilever.h"
#include "study/elastic_scenes/pendulum.h"
#include "study/elastic_scenes/plastic_set.h"
#include "study/elastic_scenes/ring_down.h"
#include "study/elastic_scenes/squash.h"
#include "study/elastic_scenes/tension.h"
#include "study/elastic_scenes/torsion.h"

namespace livegs::study {

std::string ChartScene::figure(const std::string& quantity) const {
  return name + (quantity == quantities.front() ? "" : "_" + quantity) + ".svg";
}

std::span<const ChartScene> chart_scenes() {
  static const std::vector<ChartScene> scenes = {
      {"tension",
       "Tension",
       "A free bar of 0.4 x 0.1 x 0.1 m is pulled at both ends by 0.5 % of E. Figure: error of the "
       "measured modulus over its middle half.",
       [](const Setup& setup) { return tension(setup); },
       {1e4, 1e5, 1e6, 1e7},
       0.3,
       {0.025, 0.05, 0.0125},
       16,
       {"youngs_modulus", "poisson_ratio"}},
      {"cantilever",
       "Cantilever",
       "The bar is clamped at one end and sags by 1 % of its length. Figure: error of the deflection "
       "compared with Timoshenko's beam.",
       [](const Setup& setup) { return cantilever(setup); },
       {1e4, 1e5, 1e6},
       0.0,
       {0.025, 0.05, 0.0125},
       4,
       {"deflection"}},
      {"torsion",
       "Torsion",
       "The free bar is twisted by torques at its ends. Figure: error of the twist of its middle half "
       "compared with Saint-Venant's.",
       [](const Setup& setup) { return torsion(setup); },
       {1e4, 1e5, 1e6},
       0.3,
       {0.025, 0.05, 0.0125},
       16,
       {"twist"}},
      {"ring_down",
       "Ring-down",
       "The free bar is released from 0.5 % stretch, undamped. Figures: error of the frequency of its "
       "lowest axial mode, and amplitude lost after five periods.",
       [](const Setup& setup) { return ring_down(setup); },
       {1e4, 1e5, 1e6},
       0.0,
       {0.025, 0.05, 0.0125},
       16,
       {"frequency", "amplitude"}},
      {"squash",
       "Squash by 30 %",
       "A block of 0.1 m is pressed between frictionless plates to 70 % of its height at nu 0.45. Figure: "
       "error of its volume compared with the closed form of its material.",
       [](const Setup& setup) { return squash(setup); },
       {1e4, 1e5, 1e6},
       0.45,
       {0.025, 0.05, 0.0125},
       0,
       {"volume_ratio"}},
      {"pendulum",
       "Pendulum",
       "The bar hangs from a line of fixed particles and swings freely from 5 degrees for 10 s. Figures: "
       "energy lost by the swing, and error of the period. Lattice masses are at the corners of cells, "
       "which increases the moment of inertia by m a^2 / 3; wide cells swing slower.",
       [](const Setup& setup) { return pendulum(setup); },
       {1e6},
       0.3,
       {0.025, 0.05, 0.1},
       4,
       {"energy_lost", "period"}},
      {"plastic_set",
       "Plastic set",
       "The whole boundary of a block is stretched by twice its yield strain of 0.1 at constant volume and"
       " released. Figure: error of the plastic strain compared with the closed form of return mapping for"
       " this stretch, 0.108. In simple tension it is strain minus yield, 0.1.",
       [](const Setup& setup) { return plastic_set(setup, 10.0); },
       {1e4, 1e5},
       0.3,
       {0.025, 0.05, 0.0125},
       0,
       {"set"}},
  };
  return scenes;
}

}  // namespace livegs::study
