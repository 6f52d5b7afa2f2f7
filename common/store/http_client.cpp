// SPDX-License-Identifier: Apache-2.0
#include "store/http_client.h"

#include <curl/curl.h>
#include <string.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <thread>

#include "core/assert.h"
#include "core/clock.h"
#include "core/content_hash.h"

namespace livegs {
namespace {

constexpr int kMaxPoll_ms = 1000;

std::int64_t ns_from_seconds(double seconds) { return static_cast<std::int64_t>(seconds * 1e9); }
long ms_from_seconds(double seconds) { return std::max(1L, static_cast<long>(seconds * 1e3)); }

// A transfer in progress, on the stack of send(). The worker drops its pointer before it sets `done`.
struct Transfer {
  const HttpRequest* request = nullptr;
  HttpReply reply;
  CURL* easy = nullptr;
  curl_slist* headers = nullptr;
  std::int64_t begun_ns = 0, last_byte_ns = 0;  // last_byte_ns: received or sent; at first the begin
  std::uint64_t received = 0;                   // bytes of a successful body
  std::optional<std::uint64_t> range_begin;     // of a reply of status 206
  std::size_t put_bytes = 0;                    // sent of HttpRequest::put
  bool any_byte = false, too_large = false, satisfied = false, bad_range = false;
  std::atomic<bool> cancelled = false;
  bool done = false;  // guarded by the worker's mutex
};

// Reads "bytes 100-199/200", also with * in place of the range or the total.
void read_content_range(std::string_view text, Transfer& transfer) {
  unsigned long long begin = 0, total = 0;
  const std::string line(text);
  if (std::sscanf(line.c_str(), "bytes %llu-", &begin) == 1) transfer.range_begin = begin;
  const std::size_t slash = line.find('/');
  if (slash != std::string::npos && std::sscanf(line.c_str() + slash, "/%llu", &total) == 1)
    transfer.reply.total_bytes = total;
}

long read_status(Transfer& transfer) {
  long status = 0;
  curl_easy_getinfo(transfer.easy, CURLINFO_RESPONSE_CODE, &status);
  return status;
}

// Reads the version of the object, and the size and place of the body, from the header.
void read_place(Transfer& transfer) {
  const long status = read_status(transfer);
  curl_header* header = nullptr;
  for (const char* name : {"ETag", "Last-Modified"}) {
    if (transfer.reply.version.empty() &&
        curl_easy_header(transfer.easy, name, 0, CURLH_HEADER, -1, &header) == CURLHE_OK)
      transfer.reply.version = header->value;
  }
  curl_off_t length = -1;
  if (status == 206 || status == 416) {
    if (curl_easy_header(transfer.easy, "Content-Range", 0, CURLH_HEADER, -1, &header) == CURLHE_OK)
      read_content_range(header->value, transfer);
  } else if (status == 200 &&
             curl_easy_getinfo(transfer.easy, CURLINFO_CONTENT_LENGTH_DOWNLOAD_T, &length) == CURLE_OK &&
             length >= 0) {
    transfer.reply.total_bytes = static_cast<std::uint64_t>(length);
  }
}

std::size_t receive_part(std::string_view bytes, long status, Transfer& transfer) {
  if (transfer.received == 0) read_place(transfer);
  if (status == 206 && !transfer.range_begin) {
    transfer.bad_range = true;
    return CURL_WRITEFUNC_ERROR;
  }
  const std::uint64_t offset = (status == 206 ? *transfer.range_begin : 0) + transfer.received;
  transfer.received += bytes.size();
  if (transfer.request->on_part({offset, transfer.reply.total_bytes, transfer.reply.version, bytes}))
    return bytes.size();
  transfer.satisfied = true;
  return CURL_WRITEFUNC_ERROR;
}

std::size_t send_put(char* bytes, std::size_t, std::size_t most, void* user) {
  auto& transfer = *static_cast<Transfer*>(user);
  const auto rest = transfer.request->put->subspan(transfer.put_bytes);
  const std::size_t count = std::min(most, rest.size());
  if (count > 0) std::memcpy(bytes, rest.data(), count);
  transfer.put_bytes += count;
  transfer.last_byte_ns = now_ns();
  transfer.reply.sending_s = seconds_from_ns(transfer.last_byte_ns - transfer.begun_ns);
  return count;
}

std::size_t receive_body(char* bytes, std::size_t, std::size_t count, void* user) {
  auto& transfer = *static_cast<Transfer*>(user);
  transfer.any_byte = true;
  transfer.last_byte_ns = now_ns();
  const long status = read_status(transfer);
  if (transfer.request->on_part && (status == 200 || status == 206))
    return receive_part({bytes, count}, status, transfer);
  if (transfer.reply.body.size() + count > transfer.request->max_bytes) {
    transfer.too_large = true;
    return CURL_WRITEFUNC_ERROR;
  }
  transfer.reply.body.append(bytes, count);
  if (status == 200 && transfer.request->on_body && !transfer.request->on_body({bytes, count})) {
    transfer.satisfied = true;
    return CURL_WRITEFUNC_ERROR;
  }
  return count;
}

void wipe_headers(curl_slist* headers) {
  for (curl_slist* line = headers; line; line = line->next)
    ::explicit_bzero(line->data, ::strlen(line->data));
  curl_slist_free_all(headers);
}

// libcurl signs the method, the path and these headers. It copies the keys until the request ends.
void sign(Transfer& transfer, const AwsKeys& keys) {
  const auto add = [&](const std::string& line) {
    transfer.headers = curl_slist_append(transfer.headers, line.c_str());
  };
  const auto* put = transfer.request->put;
  add("x-amz-content-sha256: " + content_hash(put ? *put : std::span<const std::byte>()));
  if (!keys.session_token.empty()) {
    std::string line = "x-amz-security-token: ";
    line.reserve(line.size() + keys.session_token.reveal().size() + 1);
    add(line += keys.session_token.reveal());
    wipe(line);
  }
  // Without this method, libcurl would send the keys themselves.
  if (curl_easy_setopt(transfer.easy, CURLOPT_AWS_SIGV4, ("aws:amz:" + keys.region + ":s3").c_str()) !=
      CURLE_OK)
    return;
  std::string pair = keys.access_key + ":";
  pair.reserve(pair.size() + keys.secret_key.reveal().size() + 1);
  pair += keys.secret_key.reveal();
  curl_easy_setopt(transfer.easy, CURLOPT_USERPWD, pair.c_str());
  wipe(pair);
}

void prepare(Transfer& transfer) {
  const HttpRequest& request = *transfer.request;
  CURL* easy = transfer.easy = curl_easy_init();
  LIVEGS_ASSERT(easy);
  const auto add = [&](const char* line) { transfer.headers = curl_slist_append(transfer.headers, line); };
  add("Expect:");  // sends the body at once instead of after a 100 Continue
  if (request.event_stream || !(request.on_part || request.put || request.head))
    add(request.event_stream ? "Accept: text/event-stream, application/json" : "Accept: application/json");
  if (!request.body.empty()) add("Content-Type: application/json");
  if (request.bearer && !request.bearer->empty()) {
    std::string line = "Authorization: Bearer ";
    line.reserve(line.size() + request.bearer->reveal().size() +
                 1);  // one buffer, so that one wipe is enough
    line += request.bearer->reveal();
    add(line.c_str());
    wipe(line);
  }
  if (request.put) add("Content-Type: application/octet-stream");
  if (request.from > 0 && !request.if_version.empty()) add(("If-Range: " + request.if_version).c_str());
  if (request.sign) sign(transfer, *request.sign);
  curl_easy_setopt(easy, CURLOPT_URL, request.url.c_str());
  curl_easy_setopt(easy, CURLOPT_HTTPHEADER, transfer.headers);
  if (!request.body.empty()) {
    curl_easy_setopt(easy, CURLOPT_POST, 1L);
    curl_easy_setopt(easy, CURLOPT_POSTFIELDS, request.body.data());
    curl_easy_setopt(easy, CURLOPT_POSTFIELDSIZE_LARGE, static_cast<curl_off_t>(request.body.size()));
  }
  if (!request.method.empty()) curl_easy_setopt(easy, CURLOPT_CUSTOMREQUEST, request.method.c_str());
  if (request.head) curl_easy_setopt(easy, CURLOPT_NOBODY, 1L);
  if (request.put) {
    curl_easy_setopt(easy, CURLOPT_UPLOAD, 1L);
    curl_easy_setopt(easy, CURLOPT_READFUNCTION, send_put);
    curl_easy_setopt(easy, CURLOPT_READDATA, &transfer);
    curl_easy_setopt(easy, CURLOPT_INFILESIZE_LARGE, static_cast<curl_off_t>(request.put->size()));
  }
  if (request.from > 0)
    curl_easy_setopt(easy, CURLOPT_RANGE, (std::to_string(request.from) + "-").c_str());  // copied
  curl_easy_setopt(easy, CURLOPT_USERAGENT, "LiveGS");
  curl_easy_setopt(easy, CURLOPT_PROTOCOLS_STR, "http,https");
  curl_easy_setopt(easy, CURLOPT_FOLLOWLOCATION, 0L);
  curl_easy_setopt(easy, CURLOPT_SSL_VERIFYPEER, 1L);
  curl_easy_setopt(easy, CURLOPT_SSL_VERIFYHOST, 2L);
  curl_easy_setopt(easy, CURLOPT_NOSIGNAL, 1L);
  curl_easy_setopt(easy, CURLOPT_QUICK_EXIT, 1L);  // a cancelled transfer does not wait for name resolution
  curl_easy_setopt(easy, CURLOPT_CONNECTTIMEOUT_MS, ms_from_seconds(request.connect_timeout_s));
  if (request.total_timeout_s > 0)
    curl_easy_setopt(easy, CURLOPT_TIMEOUT_MS, ms_from_seconds(request.total_timeout_s));
  if (is_loopback_url(request.url)) curl_easy_setopt(easy, CURLOPT_PROXY, "");
  curl_easy_setopt(easy, CURLOPT_WRITEFUNCTION, receive_body);
  curl_easy_setopt(easy, CURLOPT_WRITEDATA, &transfer);
  curl_easy_setopt(easy, CURLOPT_PRIVATE, &transfer);
}

void set_end(Transfer& transfer, HttpReply::End end, std::string message) {
  transfer.reply.end = end;
  transfer.reply.message = std::move(message);
}

// Converts the final state of libcurl to an End.
void read_end(Transfer& transfer, CURLcode code) {
  CURL* easy = transfer.easy;
  long status = 0;
  curl_easy_getinfo(easy, CURLINFO_RESPONSE_CODE, &status);
  transfer.reply.status = static_cast<int>(status);
  const char* type = nullptr;
  if (curl_easy_getinfo(easy, CURLINFO_CONTENT_TYPE, &type) == CURLE_OK && type)
    transfer.reply.content_type = type;
  curl_off_t retry_after = 0;
  if (curl_easy_getinfo(easy, CURLINFO_RETRY_AFTER, &retry_after) == CURLE_OK && retry_after > 0) {
    transfer.reply.retry_after_s = static_cast<double>(retry_after);
  }
  read_place(transfer);
  // A reused connection has a connect time of 0; the send time shows that it exists.
  curl_off_t connect_us = 0, send_us = 0;
  curl_easy_getinfo(easy, CURLINFO_CONNECT_TIME_T, &connect_us);
  curl_easy_getinfo(easy, CURLINFO_PRETRANSFER_TIME_T, &send_us);
  using End = HttpReply::End;
  const char* text = curl_easy_strerror(code);
  switch (code) {
    case CURLE_OK:
      return;
    case CURLE_WRITE_ERROR:
      if (transfer.satisfied) return;
      if (transfer.bad_range) return set_end(transfer, End::Cut, "the reply has no valid Content-Range");
      if (transfer.too_large) {
        return set_end(transfer, End::TooLarge,
                       "the reply is larger than " + std::to_string(transfer.request->max_bytes) + " bytes");
      }
      return set_end(transfer, End::Cut, text);
    case CURLE_OPERATION_TIMEDOUT:
      if (connect_us == 0 && send_us == 0)
        return set_end(transfer, End::NotConnected, "no connection in time");
      return set_end(transfer, End::Deadline, "no complete reply in time");
    case CURLE_COULDNT_RESOLVE_HOST:
    case CURLE_COULDNT_RESOLVE_PROXY:
    case CURLE_COULDNT_CONNECT:
    case CURLE_SSL_CONNECT_ERROR:  // such as a reset during the handshake, which may pass
      return set_end(transfer, End::NotConnected, text);
    case CURLE_PEER_FAILED_VERIFICATION:
    case CURLE_SSL_CACERT_BADFILE:
    case CURLE_SSL_ISSUER_ERROR:
      return set_end(transfer, End::BadTls, text);
    case CURLE_UNSUPPORTED_PROTOCOL:
    case CURLE_URL_MALFORMAT:
      return set_end(transfer, End::BadUrl, text);
    default:
      return set_end(transfer, End::Cut, text);
  }
}

}  // namespace

struct HttpClient::Worker {
  Worker() {
    static const CURLcode ready = curl_global_init(CURL_GLOBAL_DEFAULT);
    LIVEGS_ASSERT(ready == CURLE_OK);
    multi = curl_multi_init();
    LIVEGS_ASSERT(multi);
    thread = std::thread([this] { run(); });
  }
  ~Worker() {
    stopping = true;
    curl_multi_wakeup(multi);
    thread.join();
    curl_multi_cleanup(multi);
  }

  void run();
  void take_new();
  void finish(Transfer& transfer);
  int check_limits();  // ends transfers over a limit; returns milliseconds to the next limit

  CURLM* multi = nullptr;
  std::thread thread;
  std::atomic<bool> stopping = false;
  std::vector<Transfer*> active;  // worker thread only
  std::mutex mutex;               // guards arrivals and Transfer::done
  std::condition_variable ended;
  std::vector<Transfer*> arrivals;
};

void HttpClient::Worker::take_new() {
  std::vector<Transfer*> fresh;
  {
    std::lock_guard lock(mutex);
    fresh.swap(arrivals);
  }
  for (Transfer* transfer : fresh) {
    prepare(*transfer);  // hashes the bytes that are sent, which takes seconds for a large file
    transfer->begun_ns = transfer->last_byte_ns = now_ns();
    curl_multi_add_handle(multi, transfer->easy);
    active.push_back(transfer);
  }
}

void HttpClient::Worker::finish(Transfer& transfer) {
  curl_multi_remove_handle(multi, transfer.easy);
  curl_easy_cleanup(transfer.easy);
  wipe_headers(transfer.headers);
  std::erase(active, &transfer);
  std::lock_guard lock(mutex);
  transfer.done = true;
  ended.notify_all();
}

int HttpClient::Worker::check_limits() {
  using End = HttpReply::End;
  const std::int64_t now = now_ns();
  std::int64_t next = now + std::int64_t{kMaxPoll_ms} * 1000000;
  const auto passed = [&](std::int64_t moment) {
    next = std::min(next, moment);
    return now >= moment;
  };
  for (const std::vector<Transfer*> all = active; Transfer * transfer : all) {
    const HttpRequest& request = *transfer->request;
    if (transfer->cancelled || stopping) {
      set_end(*transfer, End::Cancelled, "cancelled");
      finish(*transfer);
    } else if (!transfer->any_byte && request.first_byte_timeout_s > 0 &&
               passed(transfer->last_byte_ns + ns_from_seconds(request.first_byte_timeout_s))) {
      set_end(*transfer, End::Late, "no first byte in time");
      finish(*transfer);
    } else if (transfer->any_byte && request.stall_timeout_s > 0 &&
               passed(transfer->last_byte_ns + ns_from_seconds(request.stall_timeout_s))) {
      set_end(*transfer, End::Stalled, "the reply stalled");
      finish(*transfer);
    }
  }
  return static_cast<int>(std::clamp<std::int64_t>((next - now) / 1000000 + 1, 1, kMaxPoll_ms));
}

void HttpClient::Worker::run() {
  while (!stopping || !active.empty()) {
    take_new();
    int running = 0;
    curl_multi_perform(multi, &running);
    int left = 0;
    while (CURLMsg* message = curl_multi_info_read(multi, &left)) {
      if (message->msg != CURLMSG_DONE) continue;
      Transfer* transfer = nullptr;
      const CURLcode code = message->data.result;
      curl_easy_getinfo(message->easy_handle, CURLINFO_PRIVATE, &transfer);
      read_end(*transfer, code);
      finish(*transfer);
    }
    const int wait_ms = check_limits();
    if (!stopping) curl_multi_poll(multi, nullptr, 0, wait_ms, nullptr);
  }
}

HttpClient::HttpClient() : worker_(std::make_unique<Worker>()) {}
HttpClient::~HttpClient() = default;

HttpReply HttpClient::send(const HttpRequest& request, std::stop_token stop) {
  Transfer transfer;
  transfer.request = &request;
  if (stop.stop_requested()) {
    set_end(transfer, HttpReply::End::Cancelled, "cancelled");
    return std::move(transfer.reply);
  }
  {
    std::lock_guard lock(worker_->mutex);
    worker_->arrivals.push_back(&transfer);
  }
  curl_multi_wakeup(worker_->multi);
  const std::stop_callback on_stop(stop, [&] {
    transfer.cancelled = true;
    curl_multi_wakeup(worker_->multi);
  });
  std::unique_lock lock(worker_->mutex);
  worker_->ended.wait(lock, [&] { return transfer.done; });
  return std::move(transfer.reply);
}

bool is_loopback_url(std::string_view url) {
  const std::size_t scheme = url.find("://");
  std::string_view host = scheme == std::string_view::npos ? url : url.substr(scheme + 3);
  host = host.substr(0, host.find_first_of("/?#"));
  if (host.starts_with('[')) return host.starts_with("[::1]");
  host = host.substr(0, host.find(':'));
  return host == "localhost" || host.starts_with("127.");
}

}  // namespace livegs
