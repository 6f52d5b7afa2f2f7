// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/model/model_endpoint.h"
#include "analysis/model/prompt_set.h"
#include "analysis/model/raw_answer_json.h"
#include "analysis/text/json_text.h"
#include "analysis/text/prompt_text.h"
#include "core/content_hash.h"
#include "core/file.h"
#include "core/log.h"

// Folder of recordings. endpoint.json names the last model; every <key>.json is one answer.
//
// The key is the SHA-256 of the question: prompt version (which covers all prompt texts and the schema),
// model, slots and pictures. For a repair it also covers the previous answer and the complaint.

namespace livegs {
namespace {

constexpr std::uint64_t kMaxRecordingBytes = 64 << 20;
constexpr const char* kFormat = "livegs.recording/1";

std::string hash_of(std::string_view text) { return content_hash(std::as_bytes(std::span(text))); }

class RecordedEndpoint final : public ModelEndpoint {
 public:
  RecordedEndpoint(std::filesystem::path folder, std::unique_ptr<ModelEndpoint> live, PromptSet prompts,
                   std::string recorded_model)
      : folder_(std::move(folder)),
        live_(std::move(live)),
        prompts_(std::move(prompts)),
        recorded_model_(std::move(recorded_model)) {}

  std::unique_ptr<Conversation> start(ToolBox tools) override;
  EndpointState state() const override {
    EndpointState state;
    if (live_) state = live_->state();
    state.prompt_version = prompts_.version();
    state.name = "recorded in " + folder_.string() + (live_ ? ", else " + state.name : "");
    if (!live_) {
      state.model = recorded_model_;
      state.max_in_flight = 4;
    }
    return state;
  }

  const MessageTemplates& words() const override { return prompts_.words(); }

  void get_ready(std::stop_token stop) override {
    if (live_) live_->get_ready(stop);
  }

  std::filesystem::path file_of(const std::string& key) const { return folder_ / (key + ".json"); }
  // Recordings are keyed by the configured model name, because a server may report another one.
  std::string model() const { return live_ ? live_->state().model : recorded_model_; }
  ModelEndpoint* live() const { return live_.get(); }
  const PromptSet& prompts() const { return prompts_; }
  const std::filesystem::path& folder() const { return folder_; }

 private:
  std::filesystem::path folder_;
  std::unique_ptr<ModelEndpoint> live_;
  PromptSet prompts_;
  std::string recorded_model_;
};

class RecordedExchange final : public Conversation {
 public:
  RecordedExchange(RecordedEndpoint& endpoint, ToolBox tools)
      : endpoint_(endpoint), tools_(std::move(tools)) {}

  Result<RawAnswer> ask(const AnalysisQuestion& question, std::stop_token stop) override {
    question_ = {question.slots, question.images};
    live_.reset();
    OrderedJson asked = {{"prompt_version", endpoint_.prompts().version()},
                         {"model", endpoint_.model()},
                         {"slots", OrderedJson::object()},
                         {"images", OrderedJson::array()}};
    for (const auto& [slot, value] : question_.slots) {
      if (!value.empty()) asked["slots"][slot] = plain_text(value);
    }
    for (const AnalysisImage& image : question_.images) {
      asked["images"].push_back({{"caption", plain_text(image.caption)},
                                 {"media_type", image.media_type},
                                 {"sha256", hash_of(image.bytes)}});
    }
    return find(std::move(asked), stop, [&](std::stop_token token) -> Result<RawAnswer> {
      live_ = endpoint_.live()->start(tools_);
      return live_->ask(question_, token);
    });
  }

  Result<RawAnswer> repair(std::string_view message, std::stop_token stop) override {
    if (last_.json.empty()) return invalid_argument("there is no answer to repair yet");
    OrderedJson asked = {{"after", key_}, {"answer", hash_of(last_.json)}, {"problem", plain_text(message)}};
    return find(std::move(asked), stop, [&](std::stop_token token) -> Result<RawAnswer> {
      if (!live_) {
        // The first answer was replayed; the live conversation must be held before it can continue.
        live_ = endpoint_.live()->start(tools_);
        if (auto first = live_->ask(question_, token); !first) return first.error();
      }
      return live_->repair(message, token);
    });
  }

 private:
  template <class Ask>
  Result<RawAnswer> find(OrderedJson asked, std::stop_token stop, Ask ask_live) {
    key_ = hash_of(dump_json(asked));
    const std::filesystem::path file = endpoint_.file_of(key_);
    if (std::filesystem::exists(file)) {
      Result<RawAnswer> kept = read(file);
      if (kept) last_ = *kept;
      return kept;
    }
    if (!endpoint_.live()) {
      return not_found(endpoint_.folder().string() + ": has no answer " + key_.substr(0, 12) + " about " +
                       quoted_text(question_.slots["name"]) +
                       " for these prompts, views and model; record it with an endpoint set");
    }
    Result<RawAnswer> answer = ask_live(stop);
    if (!answer) return answer;
    if (auto written = write(file, asked, *answer); !written) return written.error();
    last_ = *answer;
    return answer;
  }

  static Result<RawAnswer> read(const std::filesystem::path& file) {
    const auto text = read_text_file(file, kMaxRecordingBytes);
    if (!text) return text.error();
    const auto parsed = parse_json(*text);
    const Json* kept =
        parsed && text_member(*parsed, "format") == kFormat ? member(*parsed, "answer") : nullptr;
    auto answer = kept ? read_raw_answer(*kept) : std::nullopt;
    if (!answer)
      return invalid_data(file.string() + ": not a recorded answer; delete it and record it again");
    return std::move(*answer);
  }

  Result<void> write(const std::filesystem::path& file, const OrderedJson& asked,
                     const RawAnswer& answer) const {
    const OrderedJson recording = {
        {"format", kFormat}, {"asked", asked}, {"answer", raw_answer_json(answer)}};
    if (auto written = write_file_atomically(file, dump_json(recording) + "\n"); !written) return written;
    const OrderedJson head = {{"format", kFormat}, {"model", endpoint_.model()}};
    return write_file_atomically(endpoint_.folder() / "endpoint.json", dump_json(head) + "\n");
  }

  RecordedEndpoint& endpoint_;
  ToolBox tools_;
  std::unique_ptr<Conversation> live_;
  AnalysisQuestion question_;
  std::string key_;
  RawAnswer last_;
};

std::unique_ptr<Conversation> RecordedEndpoint::start(ToolBox tools) {
  return std::make_unique<RecordedExchange>(*this, std::move(tools));
}

}  // namespace

Result<std::unique_ptr<ModelEndpoint>> open_recorded_endpoint(const std::filesystem::path& folder,
                                                              std::unique_ptr<ModelEndpoint> live,
                                                              const std::filesystem::path& prompt_folder) {
  Result<PromptSet> prompts = PromptSet::load(prompt_folder);
  if (!prompts) return prompts.error();
  std::string model;
  if (live) {
    std::error_code failed;
    std::filesystem::create_directories(folder, failed);
    if (failed) return file_error(folder, "cannot be created", failed);
    if (live->state().model.empty()) {
      return invalid_argument(
          "LIVEGS_MODEL: must be set for a recording, which is keyed by the name of the model");
    }
  } else {
    const auto text = read_text_file(folder / "endpoint.json", kMaxRecordingBytes);
    const auto head = text ? parse_json(*text) : Result<Json>(text.error());
    model = head ? text_member(*head, "model") : "";
    if (model.empty()) {
      return not_found(folder.string() +
                       ": contains no recorded answers; record them first, with an endpoint set");
    }
  }
  return std::unique_ptr<ModelEndpoint>(
      std::make_unique<RecordedEndpoint>(folder, std::move(live), std::move(*prompts), std::move(model)));
}

}  // namespace livegs
