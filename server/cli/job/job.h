// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cli/job/eviction.h"
#include "cli/job/job_metrics.h"
#include "core/result.h"
#include "session/stored/stored_scene.h"
#include "store/object_store.h"

namespace livegs {

struct JobOptions {
  std::string checkpoints;  // place of the states and of the marks of finished jobs; empty: none
  std::string metrics;      // [HOST:]PORT; empty: none
};
// Adds --checkpoints and --metrics.
void add_job_options(CLI::App& command, JobOptions& options);

enum class JobOutput { File, Folder };

// A command whose inputs and outputs may be addresses (http://, https://, s3://), and that continues after
// its process was killed. One thread, except for progress().
//
// - Temporary files of the process are in one folder, that of the job (TMPDIR), which ~Job() and signals
//   remove.
// - Input: a file, a NAME.zip of a folder, or a NAME.scene.json of livegs publish. Fetched into the
//   folder of the job.
// - Output by address: written into the folder of the job and stored at the end.
// - Beginning, in the checkpoints: files of a local output folder may be those of an earlier run, which was
//   killed before its mark.
// - State, in the checkpoints: two objects in turn, so that one of them is whole, each with its own hash.
// - Mark, in the checkpoints: the hash and size of every output, or the printed text of a job without
//   outputs. A job whose outputs exist is done.
//
// State and mark belong to the bytes of the inputs, the options and the version: others are not used. The
// mark of a command that changes its inputs (analyze --write) belongs to the changed bytes: only a scene of a
// store is marked then.
class Job {
 public:
  // `command`: with all its options parsed.
  static Result<std::unique_ptr<Job>> begin(const CLI::App& command, const JobOptions& options);
  ~Job();
  Job(const Job&) = delete;
  Job& operator=(const Job&) = delete;

  // The local path of an input; an empty path stays empty.
  Result<std::filesystem::path> input(const std::filesystem::path& given);
  // A local file or bytes that the inputs name. Its content becomes part of the job.
  Result<void> add_input_file(const std::filesystem::path& path);
  void add_input_bytes(std::span<const std::byte> bytes);
  // The local path to write. One call for a job, after the inputs.
  Result<std::filesystem::path> output(const std::filesystem::path& given, JobOutput kind);
  // Whether an earlier run of the job noted that it begins to write its output.
  Result<bool> begun_before();
  Result<void> note_begun();

  // Whether an earlier run has finished this job.
  Result<bool> finished();
  bool keeps_state() const { return checkpoints_ != nullptr; }
  // The newest whole state, if there is one.
  Result<std::optional<std::vector<std::byte>>> last_state();
  // `step`: larger than that of the state before.
  Result<void> keep_state(size_t step, std::span<const std::byte> state);
  // The same for the .json files of a folder, for any content of the inputs; last_files() writes them there.
  Result<void> keep_files(const std::filesystem::path& folder);
  Result<void> last_files(const std::filesystem::path& folder);
  // Prints to standard output. The text is kept in the mark of a job without outputs.
  void print(const std::string& text);
  const std::string& printed() const { return printed_; }
  // Stores the outputs, the changed scene and the mark.
  Result<void> finish();

  // SIGTERM ends the process at once again: there is no state to store any more.
  void end_at_sigterm() { eviction_->listen(); }
  // A repetition works again: the work ended early, or a person decides on its result.
  void leave_unmarked() { unmarked_ = true; }
  // The command wrote into the files of its inputs. A scene of a store is published again by finish().
  void inputs_changed() { inputs_changed_ = true; }
  // For --metrics. Any thread.
  void progress(size_t done, size_t total);

 private:
  Job() = default;
  void add_to_key(const std::string& text) { key_text_ += text + "\n"; }
  Result<void> add_file_to_key(const std::filesystem::path& path);
  std::string object(const char* ending) const;  // name in the checkpoints
  Result<std::optional<std::vector<std::byte>>> state_of(const std::string& key);
  Result<void> put_state(const std::string& key, size_t step, std::span<const std::byte> state);
  Result<std::string> store_outputs();  // returns the mark: a line for each
  // `scene_list`: hash of the list of the changed scene; empty if the inputs did not change.
  Result<void> put_mark(const std::string& mark, const std::string& scene_list);
  Result<std::vector<std::filesystem::path>> output_files() const;

  std::filesystem::path folder_;  // temporary
  std::unique_ptr<Eviction> eviction_;
  // A scene of a store, and its place there.
  struct FetchedScene {
    StoredScene files;
    std::shared_ptr<ObjectStore> store;
  };
  std::vector<FetchedScene> scenes_;
  std::shared_ptr<ObjectStore> checkpoints_;
  std::string key_text_;
  std::string mark_place_, printed_;
  std::string files_key_;         // of keep_files(): command, options and version
  std::filesystem::path output_;  // local
  JobOutput output_kind_ = JobOutput::File;
  std::optional<ObjectPlace> place_;  // of the output, if it is an address
  size_t next_slot_ = 0, last_step_ = 0, inputs_ = 0;
  std::unique_ptr<JobMetrics> metrics_;
  bool unmarked_ = false, inputs_changed_ = false;
};

// Exit code for an error: kRetryExit if a repetition may succeed, else as report(). Prints the error.
int report_job(const Error& error);

// Runs a command as a job: begins it, replaces the addresses by local paths, and stores the outputs.
// `inputs`, `output`: paths of the command's options, empty if not given; a job without an output is done
// once its mark exists. `run` gives the exit code. `name_inputs` adds the files that local inputs name;
// called only with checkpoints.
int run_as_job(const CLI::App& command, const JobOptions& options, std::vector<std::filesystem::path*> inputs,
               std::filesystem::path* output, JobOutput kind, const std::function<int(Job& job)>& run,
               const std::function<Result<void>(Job& job)>& name_inputs = {});

}  // namespace livegs
