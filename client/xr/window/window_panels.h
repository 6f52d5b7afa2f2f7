// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace livegs {

// What the panels of a window show, as plain data: the window knows nothing of scenes and servers. Texts are
// ready to be read.

struct ValueRow {
  std::string name, value;  // "Mass", "0.35 kg"
  std::string origin;       // "estimate, 0.2 to 0.6 kg"
  std::string reason;
  double position = 0;                         // on the slider, 0..1
  double range_low = 0, range_high = 0;        // the band under it, 0..1; empty when equal
  std::function<std::string(double)> text_at;  // of a position, while the slider is drawn
};

struct ObjectsPanel {
  struct Entry {
    std::string name, kind, mass;  // a line of the list
  };
  std::vector<Entry> entries;
  std::optional<size_t> selected;
  std::vector<std::string> facts;  // of the selected object, a line each
  std::vector<ValueRow> rows;
  std::optional<bool> fragile;  // a tick box, when there is one
  struct Message {
    bool refusal = false;  // else a note
    std::string text;
  };
  std::vector<Message> messages;
  std::string proposal;  // what could be accepted or declined; empty when there is nothing
  std::string progress;  // of an analysis or a change under way; empty when there is none
};

// Times of the last pictures, oldest first, milliseconds.
struct FrameGraph {
  std::vector<float> picture_ms, tick_ms, age_ms;
  std::vector<float> device_ms;  // of all passes of a picture; empty where the device has no clock
};

struct RunPanel {
  bool paused = false, loading = false;
  bool recorded = false;           // nothing can be done to the scene: it is watched, and begun anew
  std::string notice;              // what is out of order, in red; empty when nothing is
  std::vector<std::string> lines;  // status, one a line
  FrameGraph graph;
  std::string latency, help;
};

// A force of chosen size and direction for a chosen time.
struct ForcePanel {
  std::string target;  // what it acts on, or how to choose it
  bool ready = false;  // a point is chosen
  double size_n = 5, duration_s = 1;
  double yaw_deg = 0, pitch_deg = 90;  // of the direction: about +Y from +Z, and upwards
  std::string sentence;                // what is done, in words
  std::string progress;                // of a recording; empty when there is none
};

// In place of all others, before there is anything to show.
struct LoadingPanel {
  std::string text;
  double share = 0;  // that is there, 0..1
};

struct WindowPanels {
  bool shown = true;
  std::optional<LoadingPanel> loading;
  RunPanel run;  // alone where it is of a recording
  ForcePanel force;
  ObjectsPanel objects;
};

// What a person did to the panels in one picture.
struct PanelActions {
  std::optional<size_t> selected;  // an entry of the list
  struct Release {
    size_t row = 0;
    double position = 0;
  };
  std::optional<Release> released;  // a slider was let go
  struct Typed {
    size_t row = 0;
    std::string text;
  };
  std::optional<Typed> typed;
  std::optional<bool> fragile;
  bool accept = false, decline = false, undo = false, redo = false, analyse = false, analyse_all = false;
  std::optional<bool> pause;
  bool step = false, reset = false;
  struct Force {
    double size_n = 0, duration_s = 0, yaw_deg = 0, pitch_deg = 0;
  };
  std::optional<Force> force;  // changed
  bool apply_force = false, record_force = false;
};

}  // namespace livegs
