// SPDX-License-Identifier: GPL-3.0-or-later
// livegs publish: stores a scene and its assets for servers and clients.
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>

#include "cli/commands.h"
#include "core/clock.h"
#include "core/log.h"
#include "session/stored/publish_scene.h"
#include "store/object_store.h"

namespace livegs {
namespace {

constexpr std::int64_t kProgress_ns = 1'000'000'000;  // between lines of progress

}  // namespace

void add_publish(CLI::App& app, int& exit_code) {
  struct Options {
    std::string scene, place;
    bool verify = false;
  };
  const auto options = std::make_shared<Options>();
  auto* command = app.add_subcommand(
      "publish", "Store a scene and its assets in a store, from which servers start and clients load assets");
  command->add_option("SCENE", options->scene, "A *.scene.json, a folder of assets or one asset")->required();
  command
      ->add_option("--asset-store", options->place,
                   "Folder of a web server, http(s):// address that accepts PUT, or s3://BUCKET/PREFIX "
                   "(AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY, AWS_REGION, AWS_ENDPOINT_URL)")
      ->required()
      ->type_name("PLACE");
  command->add_flag("--verify", options->verify,
                    "Also read the stored objects and replace those with wrong bytes");
  command->callback([options, &exit_code] {
    auto store = ObjectStore::open(options->place);
    if (!store) {
      exit_code = report(store.error());
      return;
    }
    PublishOptions publish;
    publish.verify = options->verify;
    std::int64_t shown_ns = now_ns();
    publish.progress = [&](const PublishedScene& so_far) {
      if (now_ns() - shown_ns < kProgress_ns) return;
      shown_ns = now_ns();
      log_info("%s: files: %zu, assets: %zu, written: %.1f MB, verified: %.1f MB",
               shown_url(options->place).c_str(), so_far.files, so_far.assets,
               1e-6 * static_cast<double>(so_far.written_bytes),
               1e-6 * static_cast<double>(so_far.read_bytes));
    };
    const auto done = publish_scene(options->scene, **store, publish);
    if (!done) {
      exit_code = report(done.error());
      return;
    }
    std::printf("%s  files: %zu, assets: %zu, written: %.1f MB", (*store)->shown(done->file).c_str(),
                done->files, done->assets, static_cast<double>(done->written_bytes) * 1e-6);
    if (options->verify)
      std::printf(", verified: %.1f MB, replaced: %zu", static_cast<double>(done->read_bytes) * 1e-6,
                  done->replaced);
    std::printf("\n");
  });
}

}  // namespace livegs
