// Services: a client sends a request, and the one server of that name answers it.
//
//   #include <std_srvs/srv/SetBool.hpp>  // sft_generate() makes it of std_srvs/srv/SetBool.srv
//   auto server = sft::Service<SetBool>::open(node, "lights", [](const SetBool::Request& request) {
//     return SetBool::Response{.success = true, .message = request.data ? "on" : "off"};
//   }).value();
//   auto client = sft::Client<SetBool>::open(node, "lights").value();
//   sft::Result<SetBool::Response> response = client.call({.data = true}, std::chrono::seconds(2));
//
// A service has two reliable topics: clients publish S::Call on NAME/call, and the server publishes S::Reply
// on NAME/reply. Each client subscribes to its own replies only, so that they are not sent to other hosts.
// `sft echo` shows both topics, and `sft pub NAME/call auto '{request: {data: true}}'` makes a call. Calls
// and replies have these fields:
//
//   client      a random number of the client; 0: `sft pub`, whose calls are always carried out
//   number      the number of the call, which the client counts; a repetition has the same number
//   server      in a call: the id of the server's publisher of replies, 0: any server; in a reply: that id
//   timeout_ms  how long the client repeats the call, and the server keeps the answer
//   error       not empty: there is no response, and this text is the reason
#pragma once

#include <atomic>
#include <chrono>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sft/detail/service_calls.h"
#include "sft/node.h"

namespace sft {

namespace detail {

/// A type that sft_generate() makes from a .srv file.
template <class S>
concept GeneratedService = requires(typename S::Call call, typename S::Reply reply) {
  { call.request } -> std::same_as<typename S::Request&>;
  { reply.response } -> std::same_as<typename S::Response&>;
};

}  // namespace detail

/// The server of a service. It can be moved, but not copied, and keeps its node alive. After the destructor
/// the handler does not run any more, and the calls of waiting clients fail with an error which says that
/// the server has departed.
template <detail::GeneratedService S>
class [[nodiscard]] Service {
 public:
  /// The function that answers requests. It is called once for each request by a thread of the node, one
  /// request at a time. It is a callback for samples, and the rules of such callbacks apply (subscriber.h).
  /// While it runs, other requests are queued. It returns a response, or an error whose message is sent to
  /// the client. It must not throw.
  using Handler = std::function<Result<typename S::Response>(const typename S::Request&)>;
  /// A handler that fills the response in, which may be too large for the stack. The response is as its
  /// constructor made it. After an error it is not sent.
  using FillingHandler = std::function<Result<void>(const typename S::Request&, typename S::Response&)>;

  /// Opens the server, which serves until the returned object is destroyed. If two servers have the same
  /// name, clients use neither of them. `options` are the options of the publisher of replies, for example
  /// `max_sample_bytes`. That publisher is always reliable.
  [[nodiscard]] static Result<Service> open(Node& node, std::string_view service, Handler handler,
                                            PublisherOptions options = {}) {
    static_assert(sizeof(typename S::Response) <= (1 << 20),
                  "the response is too large for the stack: let the handler fill it in: "
                  "[](const Request&, Response&) -> sft::Result<void>");
    FillingHandler fill;
    if (handler) {
      fill = [handler = std::move(handler)](const auto& request, auto& response) {
        return handler(request).map([&](typename S::Response&& made) { response = std::move(made); });
      };
    }
    return open(node, service, std::move(fill), options);
  }
  /// The same with a handler that fills the response in.
  [[nodiscard]] static Result<Service> open(Node& node, std::string_view service, FillingHandler handler,
                                            PublisherOptions options = {}) {
    if (!handler) return open(node, service, nullptr);
    options.reliability = reliable;
    auto replies = node.publisher<Reply>(detail::reply_topic(service), options);
    if (!replies) return tl::unexpected(std::move(replies.error()));
    auto state = std::make_shared<State>(std::move(handler), std::move(*replies));
    auto answer = [weak = std::weak_ptr(state)](const Sample<Call>& call) {
      if (const auto serving = weak.lock()) serving->answer(call);
    };
    return node
        .subscriber<Call>(detail::call_topic(service), answer,
                          {.transport = options.transport, .reliability = reliable})
        .map([&](Subscriber<Call>&& calls) { return Service(std::move(state), std::move(calls)); });
  }
  /// Returns an error, because there is no handler.
  [[nodiscard]] static Result<Service> open(Node&, std::string_view service, std::nullptr_t,
                                            PublisherOptions = {}) {
    return fail(Errc::invalid_argument, "service '" + std::string(service) + "': no handler");
  }

 private:
  using Call = typename S::Call;
  using Reply = typename S::Reply;
  using Served = detail::ServedCalls<Reply>;

  /// The state that the callback uses. Only the thread that runs the callback uses it.
  class State {
   public:
    State(FillingHandler handler, Publisher<Reply> replies)
        : handler_(std::move(handler)), replies_(std::move(replies)), id_(replies_.status().id) {}

    void answer(const Sample<Call>& sample) {
      const auto now = std::chrono::steady_clock::now();
      const auto call = std::make_unique<Call>();
      if (!sample.to_owned(*call) || (call->server != 0 && call->server != id_)) return;
      const typename Served::Todo todo = served_.heard(call->client, call->number, now);
      if (todo == Served::Todo::run) run(*call, now + std::chrono::milliseconds(call->timeout_ms));
      if (todo == Served::Todo::repeat) send(*served_.answer(call->client));
    }

   private:
    void run(const Call& call, detail::ServiceTime expiry) {
      auto reply = std::make_unique<Reply>();
      reply->client = call.client;
      reply->number = call.number;
      reply->server = id_;
      if (const Result<void> done = handler_(call.request, reply->response); !done)
        refuse(*reply, "the server refuses: " + done.error().message);
      send(*reply);
      served_.answered(call.client, std::move(reply), std::chrono::steady_clock::now(), expiry);
    }

    void send(Reply& reply) {
      if (replies_.publish(reply) != PublishStatus::invalid) return;
      refuse(reply, "the response cannot be sent: " + replies_.why_invalid());
      replies_.publish(reply);
    }

    static void refuse(Reply& reply, std::string reason) {
      reply.error = std::move(reason);
      reply.response = std::move(*std::make_unique<typename S::Response>());
    }

    const FillingHandler handler_;
    Publisher<Reply> replies_;
    const std::uint64_t id_;
    Served served_;
  };

  Service(std::shared_ptr<State>&& state, Subscriber<Call>&& calls)
      : state_(std::move(state)), calls_(std::move(calls)) {}

  // Shared with the running callback, because the handler may destroy the service.
  std::shared_ptr<State> state_;
  Subscriber<Call> calls_;  // destroyed first; its destructor waits for the handler
};

/// A client of a service. It can be moved, but not copied, and keeps its node alive. It must be used by
/// only one thread at a time. Threads that make calls at the same time need separate clients: a call that
/// begins while another call is running returns an error.
template <detail::GeneratedService S>
class [[nodiscard]] Client {
 public:
  using Request = typename S::Request;    ///< the request as in the .srv file
  using Response = typename S::Response;  ///< the response as in the .srv file

  /// Opens a client; the server may start later. `options` are the options of the publisher of calls, which
  /// is always reliable.
  [[nodiscard]] static Result<Client> open(Node& node, std::string_view service,
                                           PublisherOptions options = {}) {
    const std::uint64_t id = detail::new_client_id();
    options.reliability = reliable;
    auto replies = node.subscriber<Reply>(detail::reply_topic(service),
                                          {.transport = options.transport,
                                           .reliability = reliable,
                                           .selection = "@ client == " + std::to_string(id)});
    if (!replies) return tl::unexpected(std::move(replies.error()));
    auto calls = node.publisher<Call>(detail::call_topic(service), options);
    if (!calls) return tl::unexpected(std::move(calls.error()));
    return Client(id, service, std::move(*calls), std::move(*replies));
  }

  /// Returns true if there is exactly one server, and it is connected for both calls and replies.
  bool is_available() const { return detail::only_server(servers()) != nullptr; }

  /// Waits for the server, sends the request to it, repeats the request until the response arrives, and
  /// returns the response. The handler of the server runs only once. Returns an error with the reason if
  /// there is no response within `timeout`, if the server departs meanwhile, or if its handler returns an
  /// error. After an error it is unknown whether the handler has run. Must not be called in callbacks for
  /// samples, since the response could not be received until the callback returns. Call it on a thread of
  /// the program.
  [[nodiscard]] Result<Response> call(const Request& request, std::chrono::nanoseconds timeout) {
    static_assert(sizeof(Response) <= (1 << 20),
                  "the response is too large for the stack: write client.call(request, *response, timeout), "
                  "where response = std::make_unique<Response>()");
    Result<Response> response{};
    if (Result<void> done = call(request, *response, timeout); !done)
      response = tl::unexpected(std::move(done.error()));
    return response;
  }
  /// Does the same as the function above, but writes the response to an object of the program. The object
  /// does not change if there is an error.
  [[nodiscard]] Result<void> call(const Request& request, Response& response,
                                  std::chrono::nanoseconds timeout) {
    using Kind = detail::ClientCall::Step::Kind;
    if (detail::in_sample_callback()) {
      return fail(Errc::invalid_argument,
                  "service '" + service_ +
                      "': a call in a callback for samples would wait for itself: call on "
                      "a thread of the program");
    }
    const detail::OnlyCall only(*calling_);
    if (!only) {
      return fail(Errc::invalid_argument,
                  "service '" + service_ +
                      "': two threads call with one client at the same time: give each thread a client");
    }
    detail::ClientCall call(service_, now(), timeout);
    ++message_->number;
    message_->timeout_ms = call.timeout_ms();
    message_->request = request;
    for (;;) {
      if (std::optional<Result<void>> answer = take_answer(response)) return *std::move(answer);
      const detail::ClientCall::Step step = call.next(now(), servers());
      if (step.kind == Kind::fail) return fail(Errc::unavailable, step.reason);
      if (step.kind == Kind::send) {
        if (Result<void> sent = send_to(step.server); !sent) return sent;
      } else if (!replies_.wait(step.until - now()) && now() < step.until) {
        return fail(Errc::unavailable,
                    "service '" + service_ + "': waiting for the response was interrupted");
      }
    }
  }

 private:
  using Call = typename S::Call;
  using Reply = typename S::Reply;

  Client(std::uint64_t id, std::string_view service, Publisher<Call>&& calls, Subscriber<Reply>&& replies)
      : service_(service), calls_(std::move(calls)), replies_(std::move(replies)) {
    message_->client = id;
  }

  static detail::ServiceTime now() { return std::chrono::steady_clock::now(); }
  std::vector<detail::SeenServer> servers() const {
    return detail::seen_servers(calls_.status(), replies_.status());
  }

  Result<void> send_to(std::uint64_t server) {
    message_->server = server;
    const PublishStatus status = calls_.publish(*message_);
    if (status == PublishStatus::invalid) return fail(Errc::invalid_argument, calls_.why_invalid());
    if (status == PublishStatus::forked) return fail(Errc::unavailable, to_string(status));
    return {};  // a request that was not sent for lack of memory is sent again later
  }

  /// Returns the reply to the latest call, or nothing if the reply has not arrived yet. Late replies to
  /// earlier calls are dropped.
  std::optional<Result<void>> take_answer(Response& response) {
    while (const Sample<Reply> sample = replies_.take()) {
      if (sample->client() != message_->client || sample->number() != message_->number) continue;
      const auto reply = std::make_unique<Reply>();
      if (Result<void> decoded = sample.to_owned(*reply); !decoded) return decoded;
      if (!reply->error.empty())
        return fail(Errc::unavailable, "service '" + service_ + "': " + reply->error);
      response = std::move(reply->response);
      return Result<void>{};
    }
    return {};
  }

  std::string service_;
  std::unique_ptr<Call> message_ = std::make_unique<Call>();
  std::unique_ptr<std::atomic<bool>> calling_ = std::make_unique<std::atomic<bool>>(false);
  Publisher<Call> calls_;
  Subscriber<Reply> replies_;
};

}  // namespace sft
