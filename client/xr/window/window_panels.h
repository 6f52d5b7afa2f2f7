// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace livegs {

// Contents of the window's panels as plain data, independent of scenes and servers. Texts are ready for
// display.

struct ValueRow {
  std::string name, value;  // "Mass", "0.35 kg"
  std::string origin;       // "estimate, 0.2 to 0.6 kg"
  std::string reason;
  bool edited = false;                         // set by hand, so that it can go back to the estimate
  double position = 0;                         // on the slider, 0..1
  double range_low = 0, range_high = 0;        // the range below it, 0..1; empty if equal
  std::function<std::string(double)> text_at;  // formats a position while the slider is dragged
};

// The parts of an object as they are corrected. Boxes are in the object's own axes at rest, metres.
struct PartsPanel {
  struct Box {
    std::optional<std::array<double, 3>> min_m, max_m;  // none: open on these sides
  };
  struct Part {
    std::string name, material;
    double share = 0;            // of the mass, 0 to 1
    std::array<float, 3> rgb{};  // 0 to 1, display-encoded
    std::vector<Box> boxes;
  };
  std::string object;       // name
  std::vector<Part> parts;  // empty: of one material
  size_t selected = 0;      // whose boxes are drawn and edited
  bool edited = false;      // set by hand, so that they can go back to the estimate
  bool full = false;        // no more parts
  std::optional<Box> body;  // bounds of the object; none before it is loaded
};

struct ObjectsPanel {
  struct Entry {
    std::string name, kind, mass;  // a line of the list
  };
  std::vector<Entry> entries;
  std::optional<size_t> selected;
  std::vector<std::string> facts;  // of the selected object, one per line
  // Legend of the parts of the selected object, which can be shown in colours; empty: there are none. Not
  // drawn while they are edited.
  struct Part {
    std::string text;
    std::array<float, 3> rgb{};  // 0 to 1, display-encoded
  };
  std::vector<Part> parts;
  bool parts_shown = false;
  std::optional<PartsPanel> division;  // none: the parts cannot be edited
  std::vector<ValueRow> rows;
  std::optional<bool> fragile;  // a tick box, if present
  struct Message {
    bool refusal = false;  // true: an error; false: a note
    std::string text;
  };
  std::vector<Message> messages;
  std::string proposal;  // a proposal to accept or decline; empty: none
  std::string progress;  // of a running analysis or change; empty: none
};

// Times of the last pictures in milliseconds, oldest first.
struct FrameGraph {
  std::vector<float> picture_ms, tick_ms, age_ms;
  std::vector<float> device_ms;  // sum of all passes of a picture; empty if the device has no timer
};

struct RunPanel {
  bool paused = false, loading = false;
  bool waiting = false;            // before the first tick, until the user starts it
  bool recorded = false;           // playback of a recording: the scene cannot be changed
  std::string notice;              // an error, in red; empty: none
  std::vector<std::string> lines;  // status, one per line
  FrameGraph graph;
  std::string latency, help;
};

// A force with adjustable size, direction and duration.
struct ForcePanel {
  std::string target;  // target of the force, or how to choose it
  bool ready = false;  // a point is chosen
  double size_n = 5, duration_s = 1;
  double yaw_deg = 0, pitch_deg = 90;  // direction: yaw about +Y from +Z, and elevation
  std::string sentence;                // description of the force
  std::string progress;                // of a recording; empty: none
};

// The scene as authors edit it.
struct ScenePanel {
  bool available = false;  // the server lets this client edit
  std::string file;        // name, or that there is none yet
  bool unsaved = false;
  std::string undo, redo;  // titles of the next steps; empty: none
  std::string notice;      // an error; empty: none
  std::string progress;    // of the current edit; empty: none
  std::string suggested_file;
  struct Entry {
    std::string name, group;
    bool selected = false, hidden = false, locked = false;
  };
  std::vector<Entry> entries;
  int tool = 0;       // of kTools
  bool room = false;  // there is a captured room to take things from
  bool snap = false, grid = false;
  // Values of the selected object, if exactly one is selected.
  struct Fields {
    std::string name, label, label_hint, group, material;
    int behavior = 0;                                  // of kBehaviors
    double longest_side_m = 0;                         // 0: cannot be edited
    std::array<double, 3> position_m{}, angles_deg{};  // angles: yaw, pitch, roll
    bool taken = false;                                // from the captured room
  };
  std::optional<Fields> fields;
  size_t selected = 0;  // number of objects
  std::vector<std::string> labels, materials, assets, bookmarks;
  std::optional<std::array<float, 3>> background;

  static constexpr std::array<const char*, 6> kTools{"Pull",  "Move",    "Turn",
                                                     "Scale", "Measure", "Take a thing"};
  static constexpr size_t kTakeTool = 5;
  static constexpr std::array<const char*, 4> kBehaviors{"as estimated", "static", "rigid", "elastic"};
};

// Replaces all other panels until there is something to show.
struct LoadingPanel {
  std::string text;
  double share = 0;  // loaded fraction, 0..1
};

struct WindowPanels {
  bool shown = true;
  std::optional<LoadingPanel> loading;
  RunPanel run;  // the only panel for a recording
  ForcePanel force;
  ObjectsPanel objects;
  ScenePanel scene;
};

// The user's actions on the scene panel in one picture.
struct SceneActions {
  std::optional<size_t> clicked;  // an entry of the list
  bool extends = false;           // Ctrl or Shift was held
  std::optional<std::pair<size_t, bool>> hidden, locked;
  bool undo = false, redo = false, save = false, opened_assets = false;
  std::optional<std::string> save_as;
  bool replace = false;  // of save_as
  std::optional<size_t> add;
  bool duplicate = false, remove = false, drop = false, frame = false, put_back = false;
  std::optional<int> tool, behavior;
  std::optional<bool> snap, grid;
  std::optional<std::string> name, label, group, material;
  std::optional<double> longest_side_m;
  std::optional<std::array<double, 3>> position_m, angles_deg;
  std::optional<std::string> keep_bookmark;
  std::optional<size_t> go_bookmark, delete_bookmark;
  std::optional<std::array<float, 3>> background;
};

// One finished edit of the parts of an object, which may no longer be the selected one.
struct PartEdit {
  enum class Kind { Name, Material, Share, Add, Remove, AddBox, RemoveBox, MoveBox, Estimate };
  Kind kind = Kind::Name;
  std::string object;  // name
  size_t part = 0, box = 0;
  std::string text;  // Name, Material
  double share = 0;  // Share
  PartsPanel::Box moved;
};

// The user's actions on the panels in one picture.
struct PanelActions {
  std::optional<size_t> selected;  // an entry of the list
  struct Release {
    size_t row = 0;
    double position = 0;
  };
  std::optional<Release> released;  // a slider was released
  struct Typed {
    size_t row = 0;
    std::string text;
  };
  std::optional<Typed> typed;
  std::optional<size_t> estimated;  // row whose manual value is removed
  std::optional<bool> fragile, show_parts;
  std::optional<bool> parts_open;       // of the section that edits the parts, while it is drawn
  std::optional<size_t> part_selected;  // of its parts
  std::optional<PartEdit> part_edit;
  bool accept = false, decline = false, undo = false, redo = false, analyse = false, analyse_all = false;
  std::optional<bool> pause;
  bool step = false, reset = false;
  struct Force {
    double size_n = 0, duration_s = 0, yaw_deg = 0, pitch_deg = 0;
  };
  std::optional<Force> force;  // changed
  bool apply_force = false, record_force = false;
  bool start = false;  // of a simulation that waits for it
  SceneActions scene;
};

}  // namespace livegs
