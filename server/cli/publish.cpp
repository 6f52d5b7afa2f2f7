// SPDX-License-Identifier: GPL-3.0-or-later
// livegs publish: stores a scene and its assets for servers and clients.
#include <cstdio>
#include <memory>
#include <string>

#include "cli/commands.h"
#include "session/stored/publish_scene.h"
#include "store/object_store.h"

namespace livegs {

void add_publish(CLI::App& app, int& exit_code) {
  struct Options {
    std::string scene, place;
  };
  const auto options = std::make_shared<Options>();
  auto* command = app.add_subcommand(
      "publish", "Store a scene and its assets in a store, from which servers start and clients load assets");
  command->add_option("SCENE", options->scene, "A *.scene.json, a folder of assets or one asset")->required();
  command
      ->add_option(
          "--asset-store", options->place,
          "Folder that a web server serves, http(s):// address that accepts PUT, or s3://BUCKET/PREFIX "
          "(AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY, AWS_REGION, AWS_ENDPOINT_URL)")
      ->required()
      ->type_name("PLACE");
  command->callback([options, &exit_code] {
    auto store = ObjectStore::open(options->place);
    if (!store) {
      exit_code = report(store.error());
      return;
    }
    const auto done = publish_scene(options->scene, **store);
    if (!done) {
      exit_code = report(done.error());
      return;
    }
    std::printf("%s  files: %zu, assets: %zu, written: %.1f MB\n", (*store)->shown(done->file).c_str(),
                done->files, done->assets, static_cast<double>(done->written_bytes) * 1e-6);
  });
}

}  // namespace livegs
