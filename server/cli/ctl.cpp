// SPDX-License-Identifier: GPL-3.0-or-later
// livegs ctl: administers a running server through its Admin service.
#include <google/protobuf/util/json_util.h>
#include <grpcpp/create_channel.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/grpcpp.h>

#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <memory>
#include <string>

#include "cli/commands.h"
#include "cli/replay.h"
#include "core/text/help_format.h"
#include "livegs/v1/admin.grpc.pb.h"
#include "session/access/authorization.h"
#include "session/access/server_security.h"
#include "trust/host_port.h"
#include "trust/server_access.h"
#include "trust/server_probe.h"
#include "trust/state_folder.h"
#include "web/qr_text.h"

namespace livegs {
namespace {

constexpr std::chrono::seconds kPatience{5};

struct Options {
  std::string server = "127.0.0.1:9780";
  AccessOptions access;
  bool json = false;
  std::string file;
  bool inputs_only = false, with_assets = false;
  ReplayRequest replaying;
  std::string session, reason, token_id, token_name, scope = "interact";
  double days = kTokenDays;
};

// Uses the state folder of the user's own server on this machine; otherwise the same sources as
// livegs-client.
Result<std::shared_ptr<ServerAccess>> access_for(const Options& options) {
  const auto address = parse_host_port(options.server);
  if (!address) return address.error();
  const auto folder = state_folder(options.access.state_dir);
  if (folder && address->loopback) {
    const auto local = find_local_server(*folder);
    if (!local && local.error().code != ErrorCode::NotFound) return local.error();
    if (local && local->port == address->port)
      return std::make_shared<ServerAccess>(options.server,
                                            ServerAccess::Keys{local->fingerprint, "", local->token});
  }
  return choose_access(options.server, options.access);
}

// A connection to the server. Converts refusals to errors.
class Server {
 public:
  static Result<Server> reach(const Options& options) {
    auto access = access_for(options);
    if (!access) return access.error();
    Server server;
    server.address_ = options.server;
    server.access_ = std::move(*access);
    grpc::ChannelArguments arguments;
    arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
    server.channel_ = grpc::CreateCustomChannel(
        options.server, server.access_ ? server.access_->credentials() : grpc::InsecureChannelCredentials(),
        arguments);
    server.admin_ = v1::Admin::NewStub(server.channel_);
    return server;
  }

  template <class Reply, class Request>
  Result<Reply> ask(grpc::Status (v1::Admin::Stub::*method)(grpc::ClientContext*, const Request&, Reply*),
                    const Request& request) {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + kPatience);
    Reply reply;
    const grpc::Status status = (admin_.get()->*method)(&context, request, &reply);
    if (!status.ok()) return error_from(status);
    return reply;
  }

  // Queries the standard health service. The empty request stands for the server as a whole.
  Result<bool> healthy() {
    grpc::GenericStub stub(channel_);
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + kPatience);
    const grpc::ByteBuffer request(nullptr, 0);
    grpc::CompletionQueue queue;
    const auto call = stub.PrepareUnaryCall(&context, "/grpc.health.v1.Health/Check", request, &queue);
    call->StartCall();
    grpc::ByteBuffer reply;
    grpc::Status status;
    call->Finish(&reply, &status, this);
    void* tag = nullptr;
    bool ok = false;
    queue.Next(&tag, &ok);
    if (!status.ok()) return error_from(status);
    grpc::Slice bytes;
    const bool whole = reply.DumpToSingleSlice(&bytes).ok();
    return whole && bytes.size() == 2 && bytes.begin()[0] == 0x08 &&
           bytes.begin()[1] == 1;  // status: SERVING
  }

 private:
  Error error_from(const grpc::Status& status) const {
    if (access_) {
      if (auto refused = access_->refused(); !refused) return refused.error();
    }
    const bool absent = status.error_code() == grpc::StatusCode::UNAVAILABLE ||
                        status.error_code() == grpc::StatusCode::DEADLINE_EXCEEDED;
    if (absent && !access_ && speaks_tls(address_)) {
      return {ErrorCode::PermissionDenied,
              address_ +
                  ": is not the server of this state directory, since it requires TLS; give --state-dir, or "
                  "--pair CODE and --token-file for a remote server"};
    }
    const bool theirs = status.error_code() == grpc::StatusCode::INVALID_ARGUMENT ||
                        status.error_code() == grpc::StatusCode::NOT_FOUND;
    return {absent   ? ErrorCode::Unavailable
            : theirs ? ErrorCode::InvalidArgument
                     : ErrorCode::PermissionDenied,
            address_ + ": " +
                (absent ? "server does not answer; give --server HOST:PORT, and --state-dir if the server "
                          "was started with one"
                        : status.error_message())};
  }

  std::string address_;
  std::shared_ptr<ServerAccess> access_;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<v1::Admin::Stub> admin_;
};

void print_json(const google::protobuf::Message& message) {
  google::protobuf::util::JsonPrintOptions options;
  options.add_whitespace = options.preserve_proto_field_names = options.always_print_primitive_fields = true;
  std::string text;
  if (google::protobuf::util::MessageToJsonString(message, &text, options).ok())
    std::fputs(text.c_str(), stdout);
}

std::string day(int64_t unix_s) {
  const std::time_t time = unix_s;
  std::tm parts{};
  char text[32] = "";
  if (gmtime_r(&time, &parts) != nullptr) std::strftime(text, sizeof text, "%Y-%m-%d %H:%M", &parts);
  return text;
}

void print_tokens(const v1::TokenList& list) {
  std::printf("%-10s%-20s%-10s%-18s%-18s%s\n", "id", "name", "scope", "created (UTC)", "expires", "state");
  for (const v1::Token& token : list.tokens()) {
    std::printf("%-10s%-20s%-10s%-18s%-18s%s\n", token.id().c_str(), token.name().c_str(),
                scope_name(token.scope()).c_str(), day(token.made_unix_s()).c_str(),
                day(token.expires_unix_s()).c_str(),
                token.revoked()                                   ? "revoked"
                : token.expires_unix_s() <= system_wall_clock()() ? "expired"
                                                                  : "valid");
  }
}

void print_clients(const v1::ServerStatus& status) {
  std::printf("%-10s%-18s%-26s%-16s%-10s%-11s%9s%9s%10s%10s%9s\n", "session", "name", "from", "token",
              "scope", "state", "joined s", "frames", "dropped", "MB", "RTT ms");
  for (const v1::ClientStatus& client : status.clients()) {
    std::printf("%-10s%-18.17s%-26.25s%-16.15s%-10s%-11s%9.0f%9llu%10llu%10.1f%9.1f\n",
                client.session().c_str(), client.name().c_str(), client.peer().c_str(),
                client.token_name().empty() ? "-" : client.token_name().c_str(),
                scope_name(client.scope()).c_str(), client.state().c_str(), client.joined_s(),
                static_cast<unsigned long long>(client.frames_sent()),
                static_cast<unsigned long long>(client.frames_replaced()),
                static_cast<double>(client.bytes_sent()) * 1e-6, client.acknowledged_ms());
  }
}

void print_status(const v1::ServerStatus& status) {
  std::printf("scene         %s, %u objects, %.0f Hz, tick %llu\n", status.scene().c_str(), status.objects(),
              status.rate_hz(), static_cast<unsigned long long>(status.tick()));
  std::printf("server        livegs %s, protocol %u, %s, up %.0f s\n", status.version().c_str(),
              status.protocol_version(), status.serving() ? "serving" : "not serving", status.up_s());
  if (status.secure()) {
    std::printf("certificate   sha256 %s\npairing code  %s\n", status.fingerprint().c_str(),
                status.pairing_code().c_str());
  } else {
    std::printf("certificate   none; unencrypted, local connections only\n");
  }
  if (status.has_recording()) {
    const v1::RecordingStatus& recording = status.recording();
    std::printf("recording     %s: %s, %llu ticks, %.1f MB%s%s\n", recording.path().c_str(),
                recording.recording() ? "recording" : "stopped",
                static_cast<unsigned long long>(recording.ticks()),
                static_cast<double>(recording.bytes()) * 1e-6, recording.message().empty() ? "" : "; ",
                recording.message().c_str());
  }
  std::printf("clients       %d connected, %llu sessions in total\n", status.clients_size(),
              static_cast<unsigned long long>(status.sessions()));
}

void print_link(const v1::BrowserLink& link) {
  for (const std::string& url : link.urls()) std::printf("%s\n", url.c_str());
  if (::isatty(STDOUT_FILENO) != 0 && link.urls_size() > 0) std::fputs(qr_text(link.urls(0)).c_str(), stdout);
  if (!link.code().empty())
    std::printf(
        "The link is valid once, for %.0f minutes. The browser warns about the certificate. Its fingerprint "
        "is\n%s\n",
        link.valid_s() / 60, link.fingerprint().c_str());
}

// Sends a request and prints the reply, as JSON or by `table`.
template <class Request, class Reply, class Table>
int ask_and_print(const Options& options,
                  grpc::Status (v1::Admin::Stub::*method)(grpc::ClientContext*, const Request&, Reply*),
                  const Request& request, Table table) {
  auto server = Server::reach(options);
  if (!server) return report(server.error());
  const auto reply = server->ask(method, request);
  if (!reply) return report(reply.error());
  if (options.json)
    print_json(*reply);
  else
    table(*reply);
  return 0;
}

int create_token(const Options& options) {
  const auto scope = parse_scope(options.scope);
  if (!scope) return report(scope.error());
  v1::AddTokenRequest request;
  request.set_name(options.token_name);
  request.set_scope(*scope);
  request.set_days(options.days);
  return ask_and_print(options, &v1::Admin::Stub::AddToken, request, [](const v1::AddTokenReply& reply) {
    // Only the secret is printed to standard output, so that it can be redirected to a file unseen.
    std::fprintf(stderr, "token %s for %s, scope %s, valid until %s UTC; the secret is shown only once\n",
                 reply.token().id().c_str(), reply.token().name().c_str(),
                 scope_name(reply.token().scope()).c_str(), day(reply.token().expires_unix_s()).c_str());
    std::printf("%s\n", reply.secret().c_str());
  });
}

// Makes a path absolute if the server is on the same machine, because its working directory may differ.
std::string recording_path(const Options& options) {
  const auto address = parse_host_port(options.server);
  return address && address->loopback ? std::filesystem::absolute(options.file).string() : options.file;
}

int start_recording(const Options& options) {
  v1::StartRecordingRequest request;
  request.set_path(recording_path(options));
  request.set_inputs_only(options.inputs_only);
  request.set_assets(options.with_assets);
  return ask_and_print(
      options, &v1::Admin::Stub::StartRecording, request,
      [](const v1::RecordingStatus& status) { std::printf("recording %s\n", status.path().c_str()); });
}

int stop_recording(const Options& options) {
  return ask_and_print(options, &v1::Admin::Stub::StopRecording, v1::StopRecordingRequest(),
                       [](const v1::RecordingStatus& status) {
                         std::printf("recorded %s: %llu ticks, %.1f MB%s%s\n", status.path().c_str(),
                                     static_cast<unsigned long long>(status.ticks()),
                                     static_cast<double>(status.bytes()) * 1e-6,
                                     status.message().empty() ? "" : "; ", status.message().c_str());
                       });
}

int health(const Options& options) {
  auto server = Server::reach(options);
  if (!server) return report(server.error());
  const auto healthy = server->healthy();
  if (!healthy) return report(healthy.error());
  std::printf(options.json ? "{\"serving\": %s}\n" : "%s\n",
              options.json ? (*healthy ? "true" : "false") : (*healthy ? "serving" : "not serving"));
  return *healthy ? 0 : 1;
}

}  // namespace

void add_ctl(CLI::App& app, int& exit_code) {
  auto* ctl = app.add_subcommand("ctl", "Administer a running server");
  ctl->require_subcommand(1);
  ctl->fallthrough();
  auto options = std::make_shared<Options>();
  ctl->add_option("--server", options->server, "Address of the server")->capture_default_str();
  ctl->add_option("--state-dir", options->access.state_dir,
                  "State folder of a local server, or of the pairings with remote servers");
  ctl->add_option("--pair", options->access.pairing_code, "Pairing code of a remote server");
  ctl->add_option("--token-file", options->access.token_file, "File with a token of scope admin")
      ->check(CLI::ExistingFile);
  ctl->add_flag("--json", options->json, "Print JSON");
  group_options(
      *ctl, "Server",
      {{"--server", "HOST:PORT"}, {"--state-dir", "FOLDER"}, {"--pair", "CODE"}, {"--token-file", "FILE"}});
  const auto add = [&, options](CLI::App* to, const char* name, const char* about, auto run) {
    auto* command = to->add_subcommand(name, about);
    command->fallthrough();
    command->callback([options, run, &exit_code] { exit_code = run(*options); });
    return command;
  };

  add(ctl, "status", "Show the state of the server and its scene", [](const Options& given) {
    return ask_and_print(given, &v1::Admin::Stub::GetStatus, v1::GetStatusRequest(), print_status);
  });
  add(ctl, "clients", "List connected clients", [](const Options& given) {
    return ask_and_print(given, &v1::Admin::Stub::GetStatus, v1::GetStatusRequest(), print_clients);
  });
  auto* kick = add(ctl, "kick", "End a client's session", [](const Options& given) {
    v1::KickClientRequest request;
    request.set_session(given.session);
    request.set_reason(given.reason);
    return ask_and_print(given, &v1::Admin::Stub::KickClient, request, [](const v1::KickClientReply& reply) {
      std::printf("session %s ended; the client may rejoin while its token is valid\n",
                  reply.session().c_str());
    });
  });
  kick->add_option("SESSION", options->session,
                   "Session id as listed by `clients`, or a prefix of at least four digits")
      ->required();
  kick->add_option("--reason", options->reason, "Reason sent to the client")->type_name("TEXT");
  add(ctl, "health", "Check whether the server is serving; exit code 0 if it is", health);
  auto* drain = add(ctl, "drain", "Disconnect all clients and stop the server", [](const Options& given) {
    v1::DrainRequest request;
    request.set_reason(given.reason);
    return ask_and_print(given, &v1::Admin::Stub::Drain, request,
                         [](const v1::DrainReply&) { std::printf("server is shutting down\n"); });
  });
  drain->add_option("--reason", options->reason, "Reason sent to the clients");

  auto* record = ctl->add_subcommand("record", "Record the session to a file, for playback or re-simulation");
  record->require_subcommand(1);
  record->fallthrough();
  auto* begun = add(record, "start", "Start recording at the next tick", start_recording);
  begun->add_option("FILE", options->file, "New file on the server's machine, *.lvgrec")->required();
  begun->add_flag("--inputs-only", options->inputs_only,
                  "Record inputs without frames: for re-simulation only, not for playback");
  begun->add_flag("--assets", options->with_assets,
                  "Include the scene's files, so that the recording works on any machine");
  add(record, "stop", "Stop and complete the recording", stop_recording);

  auto* replayed =
      add(ctl, "replay", "Show the contents of a recording (needs no server)", [](const Options& given) {
        ReplayRequest replaying = given.replaying;
        replaying.json = given.json;
        return replay(replaying);
      });
  replayed->add_option("FILE", options->replaying.file, "Recording, *.lvgrec")->required();
  replayed->add_flag("--verify", options->replaying.verify,
                     "Simulate the recording again and compare all frames bit by bit; exit code 0 if equal");
  replayed
      ->add_option(
          "--scene", options->replaying.folder,
          "Folder of the scene's files, if they are neither in the recording nor at their original path")
      ->check(CLI::ExistingDirectory)
      ->type_name("FOLDER");

  add(ctl, "link", "Print a link, and a QR code, that opens the page in a browser", [](const Options& given) {
    return ask_and_print(given, &v1::Admin::Stub::AddBrowserLink, v1::AddBrowserLinkRequest(), print_link);
  });

  auto* tokens = ctl->add_subcommand("tokens", "Manage access tokens");
  tokens->require_subcommand(1);
  tokens->fallthrough();
  auto* made = add(tokens, "add", "Create a token and print its secret (shown only once)", create_token);
  made->add_option("NAME", options->token_name, "User or purpose of the token")->required();
  made->add_option("--scope", options->scope,
                   "view, interact, author or admin; each includes the previous ones")
      ->type_name("SCOPE")
      ->capture_default_str();
  made->add_option("--days", options->days, "Validity in days")->type_name("DAYS")->capture_default_str();
  add(tokens, "list", "List all tokens, including those that expired or were revoked in the last month",
      [](const Options& given) {
        return ask_and_print(given, &v1::Admin::Stub::ListTokens, v1::ListTokensRequest(), print_tokens);
      });
  auto* revoked =
      add(tokens, "revoke", "Revoke a token and end its sessions immediately", [](const Options& given) {
        v1::RevokeTokenRequest request;
        request.set_id(given.token_id);
        return ask_and_print(given, &v1::Admin::Stub::RevokeToken, request, [](const v1::Token& token) {
          std::printf("token %s (%s) revoked\n", token.id().c_str(), token.name().c_str());
        });
      });
  revoked
      ->add_option("ID", options->token_id,
                   "Token id as listed by `tokens list`, or a prefix of at least four digits")
      ->required();
  // After the commands of ctl, which would show it too.
  ctl->footer(
      "Examples:\n"
      "  livegs ctl status                                          # of the server on this machine\n"
      "  livegs ctl tokens add headset --scope interact > headset.token\n"
      "  livegs ctl kick 3fa9 --reason \"maintenance at noon\"");
}

}  // namespace livegs
