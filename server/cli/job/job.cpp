// SPDX-License-Identifier: GPL-3.0-or-later
#include "cli/job/job.h"

#include <stdlib.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <set>
#include <sstream>

#include "analysis/physics_file.h"
#include "cli/commands.h"
#include "cli/job/unpack_zip.h"
#include "cli/shown_paths.h"
#include "core/content_hash.h"
#include "core/file.h"
#include "core/log.h"
#include "core/text/path_ending.h"
#include "core/written_files.h"
#include "gaussian/asset_name.h"
#include "session/stored/publish_scene.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kStateHead = "livegs-state ";
// Largest state that is read back, bytes: that of training with kMaxTrainedKernels is 7e9.
constexpr uint64_t kMaxStateBytes = uint64_t{16} << 30;
// Patience while results are stored, s. A shorter outage of the store does not lose finished work.
constexpr double kResultPatience_s = 600;
// Options that do not change the bytes of the outputs.
const std::set<std::string> kNoPartOfTheJob{"--checkpoints", "--metrics", "--resume", "--every", "--help"};

std::string text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

Result<std::string> hash_of_file(const fs::path& path) {
  const auto place = open_object(path.string());
  if (!place) return place.error();
  return place->store->hash(place->name);
}

// All files below a folder, or the file itself, sorted.
Result<std::vector<fs::path>> files_below(const fs::path& path) {
  std::error_code error;
  if (!fs::is_directory(path, error)) return std::vector<fs::path>{path};
  std::vector<fs::path> files;
  for (auto at =
           fs::recursive_directory_iterator(path, fs::directory_options::follow_directory_symlink, error);
       !error && at != fs::recursive_directory_iterator(); at.increment(error)) {
    std::error_code ignored;
    if (at->is_regular_file(ignored)) files.push_back(at->path());
  }
  if (error) return file_error(path, "cannot be listed", error);
  std::sort(files.begin(), files.end());
  return files;
}

constexpr const char* kSlots[2] = {".state0", ".state1"};  // endings of the objects of states

std::string object_name(const std::string& key, const char* ending) {
  return content_hash(std::as_bytes(std::span(key))) + ending;
}

// Absolute folder of a file.
fs::path folder_of(const fs::path& file) { return fs::absolute(file).lexically_normal().parent_path(); }

// The files of a folder, not of the folders below, sorted; none if it cannot be read.
std::vector<fs::path> files_in(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code ignored;
  for (fs::directory_iterator at(folder, ignored), end; at != end; at.increment(ignored)) {
    if (at->is_regular_file(ignored)) files.push_back(at->path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

// A state with its step and its own hash in front.
struct KeptState {
  size_t step = 0;
  std::vector<std::byte> bytes;
};

std::optional<KeptState> read_state(std::vector<std::byte> object) {
  const auto end = std::find(object.begin(), object.end(), std::byte{'\n'});
  if (end == object.end()) return std::nullopt;
  std::istringstream head(text_of(std::span(object.begin(), end)));
  std::string word, hash;
  KeptState state;
  if (!(head >> word >> state.step >> hash) || word + " " != kStateHead) return std::nullopt;
  state.bytes.assign(end + 1, object.end());
  if (content_hash(state.bytes) != hash) return std::nullopt;
  return state;
}

}  // namespace

void add_job_options(CLI::App& command, JobOptions& options) {
  command
      .add_option(
          "--checkpoints", options.checkpoints,
          "Folder, http(s):// address that accepts PUT, or s3://BUCKET/PREFIX, where the state of the run is "
          "stored. The same command continues from this state. The run ends immediately if its outputs "
          "exist. Inputs "
          "may be addresses of a file, a .zip of a folder or a published scene. Outputs are stored by PUT. "
          "Exit codes: 0 success, 1 failure, 2 invalid input, 75 temporary failure (run again)")
      ->type_name("PLACE");
  command
      .add_option("--metrics", options.metrics,
                  "Serve the progress as Prometheus metrics on this port (of 127.0.0.1 without HOST)")
      ->type_name("[HOST:]PORT");
}

int report_job(const Error& error) {
  const int code = report(error);
  if (error.code == ErrorCode::PermissionDenied) return 2;
  return error.code == ErrorCode::Unavailable ? kRetryExit : code;
}

Result<std::unique_ptr<Job>> Job::begin(const CLI::App& command, const JobOptions& options) {
  std::unique_ptr<Job> job(new Job);
  std::error_code absent;
  const fs::path temporary = fs::temp_directory_path(absent);
  std::string made = (temporary / "livegs_job_XXXXXX").string();
  if (absent || ::mkdtemp(made.data()) == nullptr)
    return Error{ErrorCode::Internal,
                 made + ": cannot be created: " + (absent ? absent.message() : std::strerror(errno)) +
                     "; set TMPDIR to another folder"};
  job->folder_ = made;
  job->eviction_ = std::make_unique<Eviction>(made);
  ::setenv("TMPDIR", made.c_str(), 1);
  job->mark_place_ = options.checkpoints;
  if (!options.checkpoints.empty()) {
    auto store = ObjectStore::open(options.checkpoints);
    if (!store) return store.error();
    job->checkpoints_ = *std::move(store);
  }
  if (!options.metrics.empty()) {
    auto metrics = JobMetrics::serve(options.metrics, command.get_name());
    if (!metrics) return metrics.error();
    job->metrics_ = *std::move(metrics);
  }
  job->add_to_key("livegs " LIVEGS_VERSION " " + command.get_name());
  for (const CLI::Option* option : command.get_options()) {
    const std::string name = option->get_name();
    if (kNoPartOfTheJob.contains(name) || option->count() == 0) continue;
    job->add_to_key(name);
    for (const std::string& value : option->results()) job->add_to_key("  " + shown_url(value));
  }
  for (const char* name : {"OPENAI_BASE_URL", "LIVEGS_MODEL"}) {  // defaults of options
    if (const char* value = std::getenv(name)) job->add_to_key(std::string(name) + "  " + value);
  }
  job->files_key_ = job->key_text_ + "files\n";
  return job;
}

Job::~Job() {
  scenes_.clear();
  std::error_code ignored;
  if (!folder_.empty()) fs::remove_all(folder_, ignored);
}

Result<void> Job::add_file_to_key(const fs::path& path) {
  if (!checkpoints_) return {};
  const auto files = files_below(path);
  if (!files) return files.error();
  for (const fs::path& file : *files) {
    const auto hash = hash_of_file(file);
    if (!hash) return hash.error();
    add_to_key(file.lexically_relative(path).string() + " " + *hash);
  }
  return {};
}

Result<fs::path> Job::input(const fs::path& given) {
  if (given.empty()) return given;
  const std::string text = given.string();
  fs::path local = given;
  if (is_store_url(text)) {
    if (has_ending(shown_url(text), ".scene.json")) {
      if (text.find('?') != std::string::npos)
        return invalid_argument(shown_url(text) +
                                ": is a presigned address, which is for one object, and a scene has several; "
                                "give its s3:// address with keys, or a public address");
      auto scene = StoredScene::fetch(text, "");
      if (!scene) return scene.error();
      auto place = open_object(text, {.patience_s = kResultPatience_s});  // to publish it again
      if (!place) return place.error();
      add_to_key(scene->list_hash());
      scenes_.push_back({*std::move(scene), std::move(place->store)});
      const fs::path& path = scenes_.back().files.path();
      show_path_as(path.parent_path(), shown_url(text).substr(0, shown_url(text).rfind('/')));
      return path;
    }
    const auto place = open_object(text);
    if (!place) return place.error();
    const fs::path into = folder_ / ("input_" + std::to_string(inputs_++));
    std::error_code failed;
    fs::create_directories(into, failed);
    local = into / place->name.substr(0, place->name.find('?'));
    const auto hash = place->store->read_to_file(place->name, local);
    if (!hash) return hash.error();
    add_to_key(*hash);
    const bool zipped = has_ending(local.string(), ".zip");
    show_path_as(zipped ? into / "unpacked" : local, shown_url(text));
    if (!zipped) return local;
    return unpack_zip(local, into / "unpacked");
  }
  // A change of the files that it names would not be seen.
  if (checkpoints_ && (has_ending(text, ".scene.json") || has_ending(text, ".gltf")))
    return invalid_argument(text +
                            ": names other files, which --checkpoints cannot follow; give the folder, or "
                            "the address of a scene that livegs publish stored");
  // The index of an unpacked asset stands for its folder.
  if (auto added = add_file_to_key(is_asset_index(local) ? fs::absolute(local).parent_path() : local); !added)
    return added.error();
  // The values of an asset are an input of analyze: NAME.physics.json, those of one object, and their log.
  const fs::path values = physics_file_path(fs::absolute(local / "").lexically_normal().parent_path());
  const std::string stem = values.stem().string() + ".";
  const auto near = checkpoints_ ? files_in(values.parent_path()) : std::vector<fs::path>{};
  for (const fs::path& file : near) {
    if (!file.filename().string().starts_with(stem)) continue;
    if (auto added = add_file_to_key(file); !added) return added.error();
  }
  return local;
}

Result<void> Job::add_input_file(const fs::path& path) { return add_file_to_key(path); }
void Job::add_input_bytes(std::span<const std::byte> bytes) { add_to_key(content_hash(bytes)); }

Result<fs::path> Job::output(const fs::path& given, JobOutput kind) {
  output_ = given;
  output_kind_ = kind;
  if (!is_store_url(given.string())) return output_;
  std::string text = given.string();
  while (text.ends_with('/')) text.pop_back();
  if (kind == JobOutput::Folder && text.find('?') != std::string::npos)
    return invalid_argument(shown_url(text) +
                            ": is a presigned address, which is for one object, and the output has several; "
                            "give the s3:// address of a folder with keys");
  auto place = open_object(text, {.patience_s = kResultPatience_s});
  if (!place) return place.error();
  place_ = *std::move(place);
  std::error_code failed;
  fs::create_directories(folder_ / "output", failed);
  output_ = folder_ / "output" / place_->name.substr(0, place_->name.find('?'));
  const std::string shown = shown_url(text);
  show_path_as(output_.parent_path(), shown.substr(0, shown.rfind('/')));
  return output_;
}

std::string Job::object(const char* ending) const { return object_name(key_text_, ending); }

Result<bool> Job::finished() {
  if (!checkpoints_) return false;
  const auto mark = checkpoints_->get(object(".done"));
  if (!mark) {
    if (mark.error().code == ErrorCode::NotFound) return false;
    return mark.error();
  }
  if (output_.empty()) {
    printed_ = text_of(*mark);
    return true;
  }
  std::istringstream lines(text_of(*mark));
  size_t found = 0;
  for (std::string line; std::getline(lines, line); ++found) {
    std::istringstream words(line);
    uint64_t bytes = 0;
    std::string hash, name;
    words >> bytes >> hash >> std::ws;
    std::getline(words, name);
    if (place_ && place_->name.find('?') != std::string::npos) continue;  // presigned, for writing only
    const auto there = place_ ? place_->store->hash(name) : hash_of_file(folder_of(output_) / name);
    if (!there && place_ && there.error().code != ErrorCode::NotFound) return there.error();
    if (!there || *there != hash) return false;
  }
  return found > 0;
}

Result<std::optional<std::vector<std::byte>>> Job::last_state() { return state_of(key_text_); }

Result<std::optional<std::vector<std::byte>>> Job::state_of(const std::string& key) {
  std::optional<KeptState> newest;
  if (!checkpoints_) return std::optional<std::vector<std::byte>>();
  for (size_t slot = 0; slot < 2; ++slot) {
    auto bytes = checkpoints_->get(object_name(key, kSlots[slot]), kMaxStateBytes);
    if (!bytes && bytes.error().code != ErrorCode::NotFound) return bytes.error();
    if (!bytes) continue;
    auto state = read_state(*std::move(bytes));
    if (!state) {
      log_warn("%s: is damaged; the state before it is used",
               checkpoints_->shown(object_name(key, kSlots[slot])).c_str());
      next_slot_ = newest ? slot : next_slot_;
      continue;
    }
    if (newest && newest->step > state->step) continue;
    next_slot_ = 1 - slot;
    newest = std::move(state);
  }
  if (!newest) return std::optional<std::vector<std::byte>>();
  last_step_ = newest->step;
  log_info("continuing from the checkpoint of step %zu", newest->step);
  return std::optional<std::vector<std::byte>>(std::move(newest->bytes));
}

Result<void> Job::keep_state(size_t step, std::span<const std::byte> state) {
  return put_state(key_text_, step, state);
}

Result<void> Job::put_state(const std::string& key, size_t step, std::span<const std::byte> state) {
  const std::string head = std::string(kStateHead) + std::to_string(step) + " " + content_hash(state) + "\n";
  std::vector<std::byte> object_bytes;
  object_bytes.reserve(head.size() + state.size());
  const auto head_bytes = std::as_bytes(std::span(head));
  object_bytes.insert(object_bytes.end(), head_bytes.begin(), head_bytes.end());
  object_bytes.insert(object_bytes.end(), state.begin(), state.end());
  if (auto put = checkpoints_->put(object_name(key, kSlots[next_slot_]), object_bytes); !put) return put;
  next_slot_ = 1 - next_slot_;
  last_step_ = step;
  if (metrics_) metrics_->checkpoint_step = step;
  return {};
}

Result<bool> Job::begun_before() {
  if (!checkpoints_ || place_) return false;
  const auto noted = checkpoints_->size(object(".begun"));
  if (!noted) return noted.error();
  return noted->has_value();
}

Result<void> Job::note_begun() {
  if (!checkpoints_ || place_) return {};
  const std::string text = "begun\n";
  return checkpoints_->put(object(".begun"), std::as_bytes(std::span(text)));
}

// For each file, a line with its size in bytes and its name, and then its bytes.
Result<void> Job::keep_files(const fs::path& folder) {
  std::string all;
  for (const fs::path& file : files_in(folder)) {
    if (!has_ending(file.string(), ".json")) continue;  // still being written
    const auto text = read_text_file(file, kMaxStateBytes);
    if (!text) return text.error();
    all += std::to_string(text->size()) + " " + file.filename().string() + "\n" + *text;
  }
  return put_state(files_key_, last_step_ + 1, std::as_bytes(std::span(all)));
}

Result<void> Job::last_files(const fs::path& folder) {
  const auto state = state_of(files_key_);
  if (!state) return state.error();
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return file_error(folder, "cannot be created", error);
  const std::string all = *state ? text_of(**state) : "";
  for (size_t begin = 0; begin < all.size();) {
    const size_t end = all.find('\n', begin);
    std::istringstream head(all.substr(begin, end - begin));
    size_t size = 0;
    std::string name;
    if (end == std::string::npos || !(head >> size >> name) || fs::path(name).has_parent_path() ||
        size > all.size() - end - 1) {
      log_warn("checkpoint: is damaged; its further files are not used");
      return {};
    }
    if (auto written = write_file_atomically(folder / name, all.substr(end + 1, size)); !written)
      return written;
    begin = end + 1 + size;
  }
  return {};
}

void Job::print(const std::string& text) {
  std::fputs(text.c_str(), stdout);
  printed_ += text;
}

Result<std::vector<fs::path>> Job::output_files() const {
  // A command may write files next to its output file, with its name and another ending. The temporary folder
  // has nothing else.
  if (place_) return files_below(output_.parent_path());
  if (output_.empty() || !checkpoints_) return std::vector<fs::path>{};
  if (output_kind_ == JobOutput::File) return std::vector<fs::path>{output_};
  // Other files of a local folder are not outputs.
  std::vector<fs::path> files = written_files();
  const fs::path folder = folder_of(output_ / "file");
  std::erase_if(files, [&](const fs::path& file) {
    const fs::path inside = fs::absolute(file).lexically_normal().lexically_relative(folder);
    return inside.empty() || *inside.begin() == "..";
  });
  std::sort(files.begin(), files.end());
  return files;
}

Result<std::string> Job::store_outputs() {
  std::string mark;
  const auto files = output_files();
  if (!files) return files.error();
  for (const fs::path& file : *files) {
    const auto hash = hash_of_file(file);
    if (!hash) return hash.error();
    const std::string name =
        fs::absolute(file).lexically_normal().lexically_relative(folder_of(output_)).string();
    const bool presigned = place_ && place_->name.find('?') != std::string::npos;
    if (presigned && file != output_) {
      log_warn("%s: is not stored; a presigned address is for its own object only",
               place_->store->shown(name).c_str());
      continue;
    }
    if (place_) {
      if (auto put = place_->store->put_file(presigned ? place_->name : name, file); !put) return put.error();
    }
    std::error_code ignored;
    mark += std::to_string(fs::file_size(file, ignored)) + " " + *hash + " " + name + "\n";
  }
  return mark;
}

Result<void> Job::put_mark(const std::string& mark, const std::string& scene_list) {
  // An output that SIGTERM has removed is not done. Does not return.
  if (eviction_->asked()) eviction_.reset();
  if (!checkpoints_ || unmarked_) return {};
  std::string key = key_text_;
  if (!scene_list.empty()) {
    const std::string& before = scenes_.front().files.list_hash();
    key.replace(key.find(before), before.size(), scene_list);
  }
  const auto store = ObjectStore::open(mark_place_, {.patience_s = kResultPatience_s});
  if (!store) return store.error();
  return (*store)->put(content_hash(std::as_bytes(std::span(key))) + ".done", std::as_bytes(std::span(mark)));
}

Result<void> Job::finish() {
  const auto outputs = store_outputs();
  if (!outputs) return outputs.error();
  const std::string& mark = output_.empty() ? printed_ : *outputs;
  if (inputs_changed_) {
    // The mark is stored before the list, which completes the publication: a job that is killed in between
    // finds the scene as it was and repeats the same work, and later the changed scene with its mark.
    for (const FetchedScene& scene : scenes_) {
      const auto current = scene.files.is_current(*scene.store);
      if (!current) return current.error();
      if (!*current)
        return Error{ErrorCode::Unavailable, scene.files.path().filename().string() +
                                                 ": was published again meanwhile; repeat the command"};
      PublishOptions options;
      options.before_list = [&](const std::string& list_hash) { return put_mark(mark, list_hash); };
      const auto published = publish_scene(scene.files.path(), *scene.store, options);
      if (!published) return published.error();
    }
  } else if (auto put = put_mark(mark, ""); !put) {
    return put;
  }
  return {};
}

void Job::progress(size_t done, size_t total) {
  if (!metrics_) return;
  metrics_->steps_done = done;
  metrics_->steps = total;
}

int run_as_job(const CLI::App& command, const JobOptions& options, std::vector<fs::path*> inputs,
               fs::path* output, JobOutput kind, const std::function<int(Job& job)>& run,
               const std::function<Result<void>(Job& job)>& name_inputs) {
  auto job = Job::begin(command, options);
  if (!job) return report_job(job.error());
  for (fs::path* input : inputs) {
    auto local = (*job)->input(*input);
    if (!local) return report_job(local.error());
    *input = *std::move(local);
  }
  if (name_inputs && (*job)->keeps_state()) {
    if (auto named = name_inputs(**job); !named) return report_job(named.error());
  }
  const std::string shown = output->empty() ? "livegs " + command.get_name() : shown_url(output->string());
  if (!output->empty()) {
    auto local = (*job)->output(*output, kind);
    if (!local) return report_job(local.error());
    *output = *std::move(local);
  }
  const auto finished = (*job)->finished();
  if (!finished) return report_job(finished.error());
  if (*finished) {
    std::fputs((*job)->printed().c_str(), stdout);
    std::fprintf(stderr, "%s: is done already\n", shown.c_str());
    return 0;
  }
  const int code = run(**job);
  if (code == kInterruptedExit) (*job)->leave_unmarked();  // the best result so far is stored
  if (code != 0 && code != kInterruptedExit) return code;
  if (auto stored = (*job)->finish(); !stored) return report_job(stored.error());
  return code;
}

}  // namespace livegs
