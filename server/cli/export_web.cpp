// SPDX-License-Identifier: GPL-3.0-or-later
// livegs export web: writes a recording as a static page. The worker of the page plays film.bin and
// film.json. client/web/page/player.js describes their form.
#include <cstring>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "cli/commands.h"
#include "cli/export_scene.h"
#include "cli/output_path.h"
#include "core/clock.h"
#include "core/file.h"
#include "core/text/shown_text.h"
#include "gaussian/stored_blocks.h"
#include "recording/recording_reader.h"
#include "web/page_files.h"
#include "wire/frame_stream.h"

namespace livegs {
namespace {

void replace_once(std::string& text, std::string_view from, const std::string& to) {
  if (const size_t at = text.find(from); at != std::string::npos) text.replace(at, from.size(), to);
}

// The frames of a recording as messages of a stream.
class Film {
 public:
  Result<void> take(const RecordedEvent& recorded) {
    *events_.add_events() = recorded.event;
    const v1::SessionEvent& event = recorded.event;
    if (event.has_object_added()) set(event.object_added());
    if (event.has_object_changed()) set(event.object_changed());
    if (event.has_object_removed()) objects_.erase(event.object_removed().object_id());
    return {};
  }

  Result<void> take(const TickRecord& tick) {
    if (tick.frame.empty()) return {};
    if (tick.key) reader_ = StreamReader();
    const auto drivers = reader_.read(tick.frame);
    if (!drivers) return drivers.error();
    if (keys_.empty() && !tick.key) return {};
    if (keys_.empty()) first_ns_ = drivers->simulated_ns;
    const double at_s = seconds_from_ns(drivers->simulated_ns - first_ns_);
    // Events have a record of their own. A jump to a key skips it, because the key lists all objects.
    if (events_.events_size() > 0) append(at_s, events_);
    events_.Clear();
    if (tick.key) {
      auto& key = keys_.emplace_back(nlohmann::json::array({at_s, records_.size(), nlohmann::json::array()}));
      for (const auto& [id, description] : objects_) key[2].push_back(description);
    }
    v1::ServerMessage message;
    message.set_tick(tick.tick);
    message.mutable_run()->set_simulated_s(seconds_from_ns(drivers->simulated_ns));
    message.set_frame(tick.frame.data(), tick.frame.size());
    append(at_s, message);
    length_s_ = at_s;
    return {};
  }

  bool empty() const { return keys_.empty(); }
  const std::set<std::string>& assets() const { return assets_; }
  std::string bytes() const { return descriptions_ + records_; }
  std::string index(double rate_hz) const {
    nlohmann::json keys = keys_;
    for (nlohmann::json& key : keys) key[1] = key[1].get<size_t>() + descriptions_.size();
    return nlohmann::json{{"rate_hz", rate_hz},
                          {"length_s", length_s_},
                          {"descriptions", places_},
                          {"keys", keys},
                          {"end", descriptions_.size() + records_.size()}}
        .dump();
  }

 private:
  void set(const v1::ObjectDescription& object) {
    objects_[object.object_id()] = places_.size();
    const std::string bytes = object.SerializeAsString();
    places_.push_back({descriptions_.size(), bytes.size()});
    descriptions_ += bytes;
    assets_.insert(object.asset_hash());
    if (!object.broken_asset_hash().empty()) assets_.insert(object.broken_asset_hash());
  }
  void append(double at_s, const v1::ServerMessage& message) {
    const std::string bytes = message.SerializeAsString();
    const auto size = static_cast<uint32_t>(bytes.size());
    char head[12];
    std::memcpy(head, &size, sizeof size);
    std::memcpy(head + sizeof size, &at_s, sizeof at_s);
    records_.append(head, sizeof head);
    records_ += bytes;
  }

  std::string descriptions_, records_;
  std::vector<std::pair<size_t, size_t>> places_;  // of descriptions
  std::map<uint32_t, size_t> objects_;             // that exist: index of their latest description
  std::set<std::string> assets_;
  std::vector<nlohmann::json> keys_;
  v1::ServerMessage events_;  // since the last frame
  StreamReader reader_;
  int64_t first_ns_ = 0;
  double length_s_ = 0;
};

Result<void> write_page(const std::filesystem::path& folder) {
  for (const PageFile& file : page_files()) {
    std::string text(file.bytes);
    if (file.name == "/index.html") {
      const std::string head = "<meta charset=\"utf-8\">\n";
      replace_once(text, head,
                   head + "<meta http-equiv=\"Content-Security-Policy\" content=\"" +
                       std::string(kPagePolicy) + "\">\n");
      replace_once(text, "<body>", "<body data-film=\"./film.json\">");
    } else if (!file.named_by_content()) {
      continue;  // is for live scenes
    }
    if (auto written = write_file_atomically(folder / file.path.substr(1), text); !written) return written;
  }
  return {};
}

Result<void> export_web(const std::filesystem::path& recording, const std::filesystem::path& folder) {
  if (auto checked = check_output_folder(folder); !checked) return checked;
  std::error_code failed;
  if (std::filesystem::exists(folder, failed) && !std::filesystem::is_empty(folder, failed))
    return invalid_argument(folder.string() + ": is not empty; choose a new folder");
  auto reader = RecordingReader::open(recording);
  if (!reader) return reader.error();
  Film film;
  for (auto item = reader->next();; item = reader->next()) {
    if (!item) return item.error();
    if (!*item) break;
    const auto taken = std::visit([&](const auto& one) { return film.take(one); }, **item);
    if (!taken) return invalid_data(recording.string() + ": " + taken.error().message);
  }
  if (film.empty())
    return invalid_data(recording.string() + ": has no frames; record again without --record-inputs-only");
  std::map<std::string, std::vector<std::byte>> assets;  // read first, so that a failure leaves no files
  for (const std::string& hash : film.assets()) {
    const auto asset = reader->asset(hash);
    if (!asset)
      return invalid_data(recording.string() + ": asset " + shown_line(hash.substr(0, 12)) +
                          " is missing; record again with --record-assets");
    auto stored = store_blocks(*asset);
    if (!stored) return invalid_data(recording.string() + ": " + stored.error().message);
    assets[hash] = std::move(*stored);
  }
  std::filesystem::create_directories(folder / "assets", failed);
  if (failed)
    return invalid_argument(folder.string() + ": cannot be created: " + failed.message() +
                            "; give another folder");
  if (auto written = write_page(folder); !written) return written;
  if (auto written = write_file_atomically(folder / "film.bin", film.bytes()); !written) return written;
  if (auto written = write_file_atomically(folder / "film.json", film.index(reader->start().rate_hz()));
      !written)
    return written;
  for (const auto& [hash, bytes] : assets) {
    if (auto written = write_file_atomically(folder / "assets" / hash, bytes); !written) return written;
  }
  return {};
}

}  // namespace

void add_export(CLI::App& app, int& exit_code) {
  auto* command = app.add_subcommand("export", "Write a scene or a recording for other programs");
  command->require_subcommand(0, 1);
  struct Options {
    std::filesystem::path recording, folder;
  };
  const auto options = std::make_shared<Options>();
  auto* web = command->add_subcommand(
      "web", "Write a static page that plays a recording without a server, for any web site");
  web->add_option("RECORDING", options->recording, "A *.lvgrec file with its assets")
      ->required()
      ->check(CLI::ExistingFile);
  web->add_option("DIR", options->folder, "New or empty folder of the page")->required();
  web->callback([options, &exit_code] {
    if (const auto done = export_web(options->recording, options->folder); !done)
      exit_code = report(done.error());
  });
  add_export_scene(*command, exit_code);
}

}  // namespace livegs
