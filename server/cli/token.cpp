// SPDX-License-Identifier: GPL-3.0-or-later
// livegs token: signs a token for one server of a fleet, or makes the key of a fleet. Needs no server.
#include <cstdio>
#include <memory>
#include <string>

#include "cli/commands.h"
#include "core/text/help_format.h"
#include "session/access/authorization.h"
#include "session/access/fleet_token.h"
#include "session/access/token_store.h"

namespace livegs {
namespace {

constexpr double kMaxValid_s = kMaxTokenDays * 86400;

struct FleetTokenOptions {
  std::string key_file, new_key_file;
  std::string server, name, scope = "interact";
  double valid_s = 3600;
};

int sign_token(const FleetTokenOptions& options) {
  if (!options.new_key_file.empty()) {
    if (auto written = write_fleet_key(options.new_key_file); !written) return report(written.error());
    return 0;
  }
  const auto key = read_fleet_key(options.key_file);
  if (!key) return report(key.error());
  const auto scope = parse_scope(options.scope);
  if (!scope) return report(scope.error());
  v1::FleetToken token;
  token.set_server(options.server);
  token.set_name(options.name);
  token.set_scope(*scope);
  token.set_expires_unix_s(system_wall_clock()() + static_cast<int64_t>(options.valid_s));
  const auto text = sign_fleet_token(*key, token);
  if (!text) return report(text.error());
  std::printf("%s\n", text->c_str());
  return 0;
}

}  // namespace

void add_token(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<FleetTokenOptions>();
  CLI::App* command = app.add_subcommand("token", "Sign a token for one server of a fleet");
  auto* fresh =
      command->add_option("--new-key", options->new_key_file, "Write a new key to this file instead");
  auto* key =
      command
          ->add_option("--key", options->key_file, "Key of the fleet: the file of livegs-server --fleet-key")
          ->excludes(fresh);
  auto* server = command
                     ->add_option("--server", options->server,
                                  "Name of the server that accepts the token: its --server-name")
                     ->excludes(fresh);
  auto* name = command->add_option("--name", options->name, "Name of the person")->excludes(fresh);
  command->add_option("--scope", options->scope, "view, interact, author or admin")->capture_default_str();
  command
      ->add_option("--valid-s", options->valid_s,
                   "Seconds until the token expires. A session ends when its token expires")
      ->check(CLI::Range(1.0, kMaxValid_s))
      ->capture_default_str();
  command->footer(
      "Examples:\n"
      "  livegs token --new-key fleet.key\n"
      "  livegs token --key fleet.key --server museum-x7k2p --name ada --valid-s 7200 > ada.token");
  group_options(*command, "Options",
                {{"--key", "FILE"},
                 {"--server", "NAME"},
                 {"--name", "PERSON"},
                 {"--scope", ""},
                 {"--valid-s", "SECONDS"},
                 {"--new-key", "FILE"}});
  command->callback([=, &exit_code] {
    if (fresh->count() == 0) {
      for (const CLI::Option* needed : {key, server, name})
        if (needed->count() == 0) throw CLI::RequiredError(needed->get_name());
    }
    exit_code = sign_token(*options);
  });
}

}  // namespace livegs
