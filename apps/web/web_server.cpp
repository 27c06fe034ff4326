#include "apps/web/web_server.h"

#include <httplib.h>
#include <sys/random.h>

#include <array>
#include <chrono>
#include <condition_variable>
#include <map>
#include <mutex>
#include <thread>
#include <utility>

namespace rigcal {
namespace {

// A page keeps one connection open; more than a handful of them is nobody watching a capture.
constexpr std::size_t threads = 12;
constexpr int most_watchers = 6;
constexpr std::size_t most_body = 1024;
constexpr std::chrono::seconds keep_alive(5);

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

class WebServer::Serving {
 public:
  Serving(WebAddress address, std::string token, std::string page)
      : address_(std::move(address)), token_(std::move(token)), page_(std::move(page)) {
    server_.new_task_queue = [] { return new httplib::ThreadPool(threads); };
    // A port that another program listens on is taken; by itself httplib would share it.
    server_.set_socket_options([](socket_t socket) {
      const int yes = 1;
      ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    });
    server_.set_payload_max_length(most_body);
    server_.set_keep_alive_max_count(100);
    server_.set_read_timeout(keep_alive);
    server_.set_write_timeout(keep_alive);
    server_.set_pre_routing_handler([this](const httplib::Request& request, httplib::Response& response) {
      return admit(request, response) ? httplib::Server::HandlerResponse::Unhandled
                                      : httplib::Server::HandlerResponse::Handled;
    });
    server_.Get("/", [this](const httplib::Request&, httplib::Response& response) {
      response.set_header("Content-Security-Policy",
                          "default-src 'self'; script-src 'unsafe-inline'; style-src 'unsafe-inline'");
      response.set_content(page_, "text/html; charset=utf-8");
    });
    server_.Get("/state", [this](const httplib::Request&, httplib::Response& response) {
      const std::lock_guard lock(mutex_);
      response.set_content(state_, "application/json");
    });
    server_.Get("/picture/([A-Za-z0-9_.-]+)", [this](const httplib::Request& request, httplib::Response& response) {
      const std::lock_guard lock(mutex_);
      const auto found = pictures_.find(request.matches[1].str());
      if (found == pictures_.end()) {
        response.status = 404;
        return;
      }
      response.set_content(found->second, "image/jpeg");
    });
    server_.Get("/events", [this](const httplib::Request&, httplib::Response& response) { watch(response); });
  }
  ~Serving() {
    {
      const std::lock_guard lock(mutex_);
      is_over_ = true;
    }
    changed_.notify_all();
    server_.stop();
    if (thread_.joinable()) thread_.join();
  }
  Serving(const Serving&) = delete;
  Serving& operator=(const Serving&) = delete;

  Expected<void> start() {
    int port = address_.port;
    if (port == 0) {
      port = server_.bind_to_any_port(address_.host.c_str());  // No std::string before 0.11.
    } else if (!server_.bind_to_port(address_.host.c_str(), port)) {
      port = -1;
    }
    if (port < 0) {
      return system_error("the page cannot be served there; another program has the port, or no interface the address",
                          address_.host + ":" + std::to_string(address_.port), "give another one to --web");
    }
    address_.port = static_cast<std::uint16_t>(port);
    thread_ = std::thread([this] { server_.listen_after_bind(); });
    // What is stopped before it listens would never end.
    while (!server_.is_running()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return {};
  }

  void publish(std::string state) {
    {
      const std::lock_guard lock(mutex_);
      state_ = std::move(state);
      ++number_;
    }
    changed_.notify_all();
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
  bool admit(const httplib::Request& request, httplib::Response& response) const {
    response.set_header("Cache-Control", "no-store");
    response.set_header("X-Content-Type-Options", "nosniff");
    if (request.method != "GET") {
      response.status = 405;
      return false;
    }
    if (token_.empty()) return is_asked_by_name_of_this_machine(request, response);
    const std::string given = request.get_param_value("token");
    if (is_same_secret(given, token_)) {
      response.set_header("Set-Cookie", "rigcal_token=" + token_ + "; HttpOnly; SameSite=Strict; Path=/");
      return true;
    }
    if (is_same_secret(cookie_value(request.get_header_value("Cookie"), "rigcal_token"), token_)) return true;
    response.status = 403;
    response.set_content("The address of this page has a token, which rigcal capture printed.\n", "text/plain");
    return false;
  }
  // A page of another site, whose name was made to lead to this machine, must not read this one.
  static bool is_asked_by_name_of_this_machine(const httplib::Request& request, httplib::Response& response) {
    if (is_host_of_this_machine(request.get_header_value("Host"))) return true;
    response.status = 403;
    response.set_content("This page is served to localhost alone.\n", "text/plain");
    return false;
  }

  void watch(httplib::Response& response) {
    {
      const std::lock_guard lock(mutex_);
      if (watchers_ >= most_watchers) {
        response.status = 503;
        return;
      }
      ++watchers_;
    }
    auto seen = std::make_shared<std::uint64_t>(0);
    response.set_chunked_content_provider(
        "text/event-stream",
        [this, seen](std::size_t, httplib::DataSink& sink) {
          std::string text;
          {
            std::unique_lock lock(mutex_);
            const bool is_news = changed_.wait_for(lock, keep_alive, [&] { return is_over_ || number_ != *seen; });
            if (is_over_) return false;
            text = is_news ? "data: " + state_ + "\n\n" : ": still there\n\n";
            *seen = number_;
          }
          return sink.write(text.data(), text.size());
        },
        [this](bool) {
          const std::lock_guard lock(mutex_);
          --watchers_;
        });
  }

  WebAddress address_;
  std::string token_;
  std::string page_;
  httplib::Server server_;
  std::mutex mutex_;  ///< Of what follows.
  std::condition_variable changed_;
  std::string state_ = "null";
  std::uint64_t number_ = 1;
  std::map<std::string, std::string> pictures_;
  int watchers_ = 0;
  bool is_over_ = false;
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
