#include "apps/web/web_server.h"

#include <microhttpd.h>
#include <netdb.h>
#include <sys/random.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <map>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

namespace rigcal {
namespace {

using Clock = std::chrono::steady_clock;

// A page keeps one connection open; more than a handful of them is nobody watching a capture. Who finds no place waits
// in the kernel, where it costs no descriptor.
constexpr unsigned most_connections = 12;
constexpr int most_watchers = 6;
// For a head and what of its answer is on its way. Browsers also send the cookies of what else runs on localhost.
constexpr std::size_t most_memory = 32 * 1024;
constexpr unsigned patience_s = 5;
constexpr std::chrono::seconds patience(patience_s);
constexpr std::size_t piece_of_stream = 4096;
// How late news may be, and the end.
constexpr std::chrono::milliseconds tick(100);

struct Answer {
  unsigned status = MHD_HTTP_OK;
  std::string text{};
  const char* type = nullptr;
  bool is_stream = false;  ///< Of events, in place of the text.
};

std::string_view value_of(MHD_Connection* connection, MHD_ValueKind kind, std::string_view key) {
  const char* value = nullptr;
  std::size_t size = 0;
  const auto found = MHD_lookup_connection_value_n(connection, kind, key.data(), key.size(), &value, &size);
  return found == MHD_YES && value != nullptr ? std::string_view(value, size) : std::string_view();
}

}  // namespace

Expected<std::string> make_token() {
  std::array<unsigned char, 16> bytes{};
  if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
    return system_error("the system gives no random numbers", "getrandom", "serve the page on loopback");
  }
  std::string token;
  constexpr const char* digits = "0123456789abcdef";
  for (const unsigned char byte : bytes) {
    token += digits[byte >> 4U];
    token += digits[byte & 15U];
  }
  return token;
}

// The library is called by one thread alone, which waits for all connections at once and for no single one.
class WebServer::Serving {
 public:
  Serving(WebAddress address, std::string token, std::string page)
      : address_(std::move(address)), token_(std::move(token)), page_(std::move(page)) {}
  ~Serving() {
    is_over_ = true;
    if (thread_.joinable()) thread_.join();
    for (auto& [connection, visitor] : visitors_) wake(visitor);  // The library closes none that sleeps.
    if (daemon_ != nullptr) MHD_stop_daemon(daemon_);
  }
  Serving(const Serving&) = delete;
  Serving& operator=(const Serving&) = delete;

  Expected<void> start() {
    addrinfo hints{};
    hints.ai_socktype = SOCK_STREAM;
    hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
    addrinfo* places = nullptr;
    if (::getaddrinfo(address_.host.c_str(), std::to_string(address_.port).c_str(), &hints, &places) == 0) {
      for (const addrinfo* place = places; place != nullptr && daemon_ == nullptr; place = place->ai_next)
        daemon_ = listen_at(*place);
      ::freeaddrinfo(places);
    }
    if (daemon_ == nullptr) {
      return system_error("the page cannot be served there; another program has the port, or no interface the address",
                          address_.host + ":" + std::to_string(address_.port), "give another one to --web");
    }
    address_.port = MHD_get_daemon_info(daemon_, MHD_DAEMON_INFO_BIND_PORT)->port;
    thread_ = std::thread([this] { run(); });
    return {};
  }

  void publish(std::string state) {
    const std::lock_guard lock(mutex_);
    state_ = std::move(state);
    ++number_;
  }
  void publish_picture(const std::string& name, std::string jpeg) {
    const std::lock_guard lock(mutex_);
    pictures_[name] = std::move(jpeg);
  }
  [[nodiscard]] std::uint16_t port() const { return address_.port; }
  [[nodiscard]] std::string url() const {
    const bool is_v6 = address_.host.find(':') != std::string::npos;
    std::string url = "http://" + (is_v6 ? "[" + address_.host + "]" : address_.host) + ":";
    url += std::to_string(address_.port) + "/";
    return token_.empty() ? url : url + "?token=" + token_;
  }

 private:
  struct Visitor {
    Serving* serving = nullptr;
    MHD_Connection* connection = nullptr;
    std::optional<Clock::time_point> head_due = Clock::now() + patience;  ///< None once it is there.
    // Of one that watches events:
    bool is_watching = false;
    bool is_asleep = false;  ///< Until there is something to be told.
    std::uint64_t seen = 0;
    Clock::time_point told{};
    std::string text{};    ///< What it is being told,
    std::size_t sent = 0;  ///< and how much of that has gone out.
  };

  // A port that another program listens on is taken: the library shares none unless it is asked to.
  MHD_Daemon* listen_at(const addrinfo& place) {
    unsigned flags = MHD_USE_EPOLL | MHD_ALLOW_SUSPEND_RESUME;
    if (place.ai_family == AF_INET6) flags |= MHD_USE_DUAL_STACK;
    return MHD_start_daemon(flags, 0, nullptr, nullptr, &Serving::answer, this, MHD_OPTION_SOCK_ADDR, place.ai_addr,
                            MHD_OPTION_CONNECTION_LIMIT, most_connections, MHD_OPTION_LISTEN_BACKLOG_SIZE,
                            most_connections, MHD_OPTION_CONNECTION_MEMORY_LIMIT, most_memory,
                            MHD_OPTION_CONNECTION_TIMEOUT, patience_s, MHD_OPTION_NOTIFY_CONNECTION,
                            &Serving::come_or_gone, this, MHD_OPTION_END);
  }

  void run() {
    while (!is_over_) {
      if (MHD_run_wait(daemon_, static_cast<int>(tick.count())) != MHD_YES) std::this_thread::sleep_for(tick);
      for (auto& [connection, visitor] : visitors_) {
        if (visitor.is_asleep && has_news_for(visitor)) wake(visitor);
        // The library's own timeout begins anew with every byte.
        if (visitor.head_due && Clock::now() > *visitor.head_due)
          ::shutdown(MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD)->connect_fd, SHUT_RDWR);
      }
    }
  }
  static void wake(Visitor& visitor) {
    if (std::exchange(visitor.is_asleep, false)) MHD_resume_connection(visitor.connection);
  }
  static void come_or_gone(void* self, MHD_Connection* connection, void** /*unused*/,
                           MHD_ConnectionNotificationCode code) {
    auto* serving = static_cast<Serving*>(self);
    serving->visitors_.erase(connection);
    if (code == MHD_CONNECTION_NOTIFY_STARTED) serving->visitors_.emplace(connection, Visitor{serving, connection});
  }
  // Called when the whole head is there. As it is answered at once, a body is not read.
  static MHD_Result answer(void* self, MHD_Connection* connection, const char* path, const char* method,
                           const char* /*version*/, const char* /*body*/, std::size_t* /*unused*/, void** /*unused*/) {
    auto* serving = static_cast<Serving*>(self);
    Visitor& visitor = serving->visitors_.at(connection);
    visitor.head_due.reset();
    Answer answer = serving->answer_to(connection, path, method);
    visitor.is_watching = answer.is_stream;
    MHD_Response* response =
        answer.is_stream
            ? MHD_create_response_from_callback(MHD_SIZE_UNKNOWN, piece_of_stream, &Serving::tell, &visitor, nullptr)
            : MHD_create_response_from_buffer(answer.text.size(), answer.text.data(), MHD_RESPMEM_MUST_COPY);
    if (response == nullptr) return MHD_NO;
    serving->add_headers(response, answer, serving->is_token(token_in_address(connection)));
    const MHD_Result result = MHD_queue_response(connection, answer.status, response);
    MHD_destroy_response(response);
    return result;
  }
  void add_headers(MHD_Response* response, const Answer& answer, bool has_shown_token) const {
    const auto add = [response](const char* name, const std::string& value) {
      static_cast<void>(MHD_add_response_header(response, name, value.c_str()));
    };
    add("Cache-Control", "no-store");
    add("X-Content-Type-Options", "nosniff");
    add("Content-Security-Policy", "default-src 'self'; script-src 'unsafe-inline'; style-src 'unsafe-inline'");
    if (answer.type != nullptr) add("Content-Type", answer.type);
    add("Connection", "close");  // Nobody keeps a place that asks for nothing.
    if (has_shown_token) add("Set-Cookie", "rigcal_token=" + token_ + "; HttpOnly; SameSite=Strict; Path=/");
  }

  Answer answer_to(MHD_Connection* connection, const std::string& path, std::string_view method) const {
    if (method != "GET") return {MHD_HTTP_METHOD_NOT_ALLOWED};
    if (const char* reason = refusal(connection)) return {MHD_HTTP_FORBIDDEN, reason, "text/plain"};
    if (path == "/") return {MHD_HTTP_OK, page_, "text/html; charset=utf-8"};
    if (path == "/events") {
      const auto watchers = std::ranges::count_if(visitors_, [](const auto& one) { return one.second.is_watching; });
      if (watchers >= most_watchers) return {MHD_HTTP_SERVICE_UNAVAILABLE};
      return {MHD_HTTP_OK, {}, "text/event-stream", true};
    }
    const std::lock_guard lock(mutex_);
    if (path == "/state") return {MHD_HTTP_OK, state_, "application/json"};
    const std::string_view folder = "/picture/";
    const auto picture = path.starts_with(folder) ? pictures_.find(path.substr(folder.size())) : pictures_.end();
    if (picture == pictures_.end()) return {MHD_HTTP_NOT_FOUND};
    return {MHD_HTTP_OK, picture->second, "image/jpeg"};
  }
  // Why it is not answered; null where it is.
  const char* refusal(MHD_Connection* connection) const {
    if (token_.empty()) {
      // A page of another site, whose name was made to lead to this machine, must not read this one.
      const bool is_own = is_host_of_this_machine(value_of(connection, MHD_HEADER_KIND, "Host"));
      return is_own ? nullptr : "This page is served to localhost alone.\n";
    }
    const std::string_view cookies = value_of(connection, MHD_HEADER_KIND, "Cookie");
    if (is_token(token_in_address(connection)) || is_token(cookie_value(cookies, "rigcal_token"))) return nullptr;
    return "The address of this page has a token, which rigcal capture printed.\n";
  }
  static std::string_view token_in_address(MHD_Connection* connection) {
    return value_of(connection, MHD_GET_ARGUMENT_KIND, "token");
  }
  bool is_token(std::string_view given) const { return !token_.empty() && is_same_secret(given, token_); }

  // The next piece for one that watches events.
  static ssize_t tell(void* one, std::uint64_t /*position*/, char* piece, std::size_t most) {
    auto& visitor = *static_cast<Visitor*>(one);
    if (visitor.sent == visitor.text.size()) {
      if (!visitor.serving->has_news_for(visitor)) {
        visitor.is_asleep = true;
        MHD_suspend_connection(visitor.connection);
        return 0;
      }
      visitor.serving->take_news(visitor);
    }
    const std::size_t size = visitor.text.copy(piece, most, visitor.sent);
    visitor.sent += size;
    return static_cast<ssize_t>(size);
  }
  bool has_news_for(const Visitor& visitor) const {
    const std::lock_guard lock(mutex_);
    return visitor.seen != number_ || Clock::now() > visitor.told + patience;
  }
  void take_news(Visitor& visitor) const {
    const std::lock_guard lock(mutex_);
    visitor.text = visitor.seen != number_ ? "data: " + state_ + "\n\n" : ": still there\n\n";
    visitor.sent = 0;
    visitor.seen = number_;
    visitor.told = Clock::now();
  }

  WebAddress address_;
  std::string token_;
  std::string page_;
  MHD_Daemon* daemon_ = nullptr;
  std::map<MHD_Connection*, Visitor> visitors_;
  std::atomic<bool> is_over_ = false;
  mutable std::mutex mutex_;  ///< Of what follows.
  std::string state_ = "null";
  std::uint64_t number_ = 1;
  std::map<std::string, std::string> pictures_;
  std::thread thread_;
};

WebServer::WebServer(std::unique_ptr<Serving> serving) : serving_(std::move(serving)) {}
WebServer::~WebServer() = default;

Expected<std::unique_ptr<WebServer>> WebServer::start(const WebAddress& address, std::string token, std::string page) {
  auto serving = std::make_unique<Serving>(address, std::move(token), std::move(page));
  if (const auto started = serving->start(); !started) return started.error();
  return std::unique_ptr<WebServer>(new WebServer(std::move(serving)));
}

void WebServer::publish(std::string state) { serving_->publish(std::move(state)); }
void WebServer::publish_picture(const std::string& name, std::string jpeg) {
  serving_->publish_picture(name, std::move(jpeg));
}
std::uint16_t WebServer::port() const { return serving_->port(); }
std::string WebServer::url() const { return serving_->url(); }

}  // namespace rigcal
