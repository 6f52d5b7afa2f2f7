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
       "A free bar of 0.4 x 0.1 x 0.1 m is pulled at both ends by 0.5 % of E; error of the modulus it shows "
       "over its "
       "middle half.",
       [](const Setup& setup) { return tension(setup); },
       {1e4, 1e5, 1e6, 1e7},
       0.3,
       {0.025, 0.05, 0.0125},
       16,
       {"youngs_modulus", "poisson_ratio"}},
      {"cantilever",
       "Cantilever",
       "The bar is clamped at one end and sags by 1 % of its length; error of the deflection against "
       "Timoshenko's beam.",
       [](const Setup& setup) { return cantilever(setup); },
       {1e4, 1e5, 1e6},
       0.0,
       {0.025, 0.05, 0.0125},
       4,
       {"deflection"}},
      {"torsion",
       "Torsion",
       "The free bar is twisted by torques at its ends; error of the twist of its middle half against "
       "Saint-Venant's.",
       [](const Setup& setup) { return torsion(setup); },
       {1e4, 1e5, 1e6},
       0.3,
       {0.025, 0.05, 0.0125},
       16,
       {"twist"}},
      {"ring_down",
       "Ring-down",
       "The free bar is let go from 0.5 % stretch, undamped; error of the frequency of its lowest axial "
       "mode, and what is "
       "lost of its amplitude after five periods.",
       [](const Setup& setup) { return ring_down(setup); },
       {1e4, 1e5, 1e6},
       0.0,
       {0.025, 0.05, 0.0125},
       16,
       {"frequency", "amplitude"}},
      {"squash",
       "Squash by 30 %",
       "A block of 0.1 m is pressed between frictionless plates to 70 % of its height at nu 0.45; error of "
       "its volume "
       "against its own material's closed form.",
       [](const Setup& setup) { return squash(setup); },
       {1e4, 1e5, 1e6},
       0.45,
       {0.025, 0.05, 0.0125},
       0,
       {"volume_ratio"}},
      {"pendulum",
       "Pendulum",
       "The bar hangs from a line of held particles and swings freely from 5 degrees for 10 s: energy of the "
       "swing that is "
       "lost, and error of the period. Lattice masses stand at the corners of cells, which makes a body turn "
       "as if its "
       "moment of inertia were m a^2 / 3 larger; wide cells swing slower for it.",
       [](const Setup& setup) { return pendulum(setup); },
       {1e6},
       0.3,
       {0.025, 0.05, 0.1},
       4,
       {"energy_lost", "period"}},
      {"plastic_set",
       "Plastic set",
       "A block's whole boundary is stretched by twice its yield strain of 0.1, keeping its volume, and let "
       "go; error of the "
       "strain that stays against return mapping's closed form for that stretch, 0.108 (goal 0.1, strain "
       "minus yield, which "
       "is what stays in simple tension).",
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
