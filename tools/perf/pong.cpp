#include "tools/perf/pong.h"

#include <fmt/format.h>

#include <algorithm>
#include <mutex>
#include <utility>

#include "tools/perf/floor.h"
#include "tools/perf/message.h"
#include "tools/perf/protocol.h"
#include "tools/terminal/units.h"

namespace sft::perf {

using namespace std::chrono_literals;

namespace {

// The limit for the arrival of the message, and then for the first samples
constexpr std::int64_t timeout_ns = 5'000'000'000;
constexpr std::size_t streams_max = 8;
constexpr std::size_t sessions_max = 16;

}  // namespace

/// The samples of one selection, and their answers.
class Echo {
 public:
  static Result<std::unique_ptr<Echo>> open(Node& node, const Offer& offer, std::size_t number,
                                            const DynamicType& type, std::shared_ptr<const Payload> payload) {
    std::unique_ptr<Echo> echo(new Echo);
    const std::string suffix = std::to_string(number);
    if (offer.answers) {
      Result<Sender> sender = Sender::open(
          node, topic_of(offer.session, "answers" + suffix), type, std::move(payload), offer.loans,
          {.transport = offer.transport, .reliability = offer.reliable ? reliable : best_effort});
      if (!sender) return tl::unexpected(sender.error());
      echo->answers_.emplace(*std::move(sender));
    }
    Echo* const self = echo.get();
    auto subscriber = node.subscriber(
        topic_of(offer.session, "samples" + suffix), type, offer.fields[number],
        {.transport = offer.transport, .reliability = offer.reliable ? reliable : best_effort, .depth = 256},
        [self](const DynamicSample& sample) { self->note(sample); });
    if (!subscriber) return tl::unexpected(subscriber.error());
    echo->samples_ = *std::move(subscriber);
    return echo;
  }

  Report::Stream report() {
    const std::uint64_t lost = samples_->status().lost;
    const std::uint64_t publisher = answers_ ? answers_->status().id : 0;
    const std::scoped_lock lock(mutex_);
    return {publisher, received_, lost, answered_.take_parts()};
  }
  bool is_left() const { return samples_->status().writers.empty(); }
  std::uint64_t received() {
    const std::scoped_lock lock(mutex_);
    return received_;
  }

 private:
  Echo() = default;

  void note(const DynamicSample& sample) {
    const bool answered = answers_ && answers_->send();
    const std::scoped_lock lock(mutex_);
    ++received_;
    if (answered) answered_.note(sample.info().sequence);
  }

  std::optional<Sender> answers_;
  std::mutex mutex_;  // guards the next two members
  std::uint64_t received_ = 0;
  Answered answered_;
  std::optional<DynamicSubscriber> samples_;  // must be the last member, because its callbacks use the others
};

class Pong::Session {
 public:
  Session(Node& node, Offer offer)
      : offer_(std::move(offer)),
        reports_(node.publisher(topic_of(offer_.session, "reports"), text_type(), retained())),
        type_(from_msg(offer_.type, offer_.definition)) {
    if (const Result<void> opened = subscribe(node); !opened) error_ = opened.error().message;
  }

  std::uint64_t id() const { return offer_.session; }
  const std::string& error() const { return error_; }
  std::string name() const {
    return fmt::format("{}, {}, {}", offer_.type, fmt::join(offer_.fields, " | "),
                       offer_.reliable ? "reliable" : "best effort");
  }

  bool waits() const { return waits_; }
  /// Begins the run once the message has arrived. If it has not arrived in time, the run fails with an
  /// error. Reports the beginning or the error. Returns true if this happened in this call.
  bool begin(Node& node) {
    if (!waits_) return false;
    if (error_.empty()) {
      const DynamicSample message = messages_->take();
      if (!message && now_ns() - since_ns_ < timeout_ns) return false;
      if (const Result<void> opened = open(node, message); !opened) error_ = opened.error().message;
    }
    waits_ = false;
    since_ns_ = now_ns();
    report(0);
    return true;
  }

  void report(std::uint64_t mark) {
    Report report{.session = offer_.session, .side = side_, .mark = mark, .error = error_};
    report.clock = host_clock();
    for (const auto& echo : echoes_) report.streams.push_back(echo->report());
    report.udp_port = udp_ ? udp_->port() : 0;
    report.tcp_port = tcp_ ? tcp_->port() : 0;
    report.udp_received = udp_ ? udp_->received() : 0;
    report.tcp_received = tcp_ ? tcp_->received() : 0;
    report.usage = usage_now();
    if (reports_) (void)publish_text(*reports_, text_of(report));
  }

  /// Notes that the last report was made. The session is kept until the sending side has received it.
  void end() { ended_ = true; }
  bool is_under_way() const { return !ended_ && error_.empty(); }
  /// Returns true if the sending side is gone, or has never appeared.
  bool is_left() {
    const bool is_over = !waits_ && now_ns() - since_ns_ > timeout_ns;
    if (!error_.empty() || waits_) return is_over;
    const bool left = std::ranges::any_of(echoes_, [](const auto& echo) { return echo->is_left(); });
    was_there_ = was_there_ || !left;
    return left && (was_there_ || is_over);
  }

  std::uint64_t received() const {
    std::uint64_t received = 0;
    for (const auto& echo : echoes_) received += echo->received();
    return received;
  }
  /// Returns the number of samples that have arrived since the last call.
  std::uint64_t fresh() {
    const std::uint64_t now = received();
    return now - std::exchange(shown_, now);
  }
  Usage usage() const { return usage_now() - began_; }

 private:
  Result<void> subscribe(Node& node) {
    if (offer_.fields.empty() || offer_.fields.size() > streams_max)
      return fail(Errc::invalid_argument, "the offer has no selections, or too many");
    if (!type_) return tl::unexpected(type_.error());
    return node
        .subscriber(topic_of(offer_.session, "message"), *type_, "*",
                    {.reliability = reliable, .durability = transient_local})
        .map([&](DynamicSubscriber&& messages) { messages_.emplace(std::move(messages)); });
  }

  Result<void> open(Node& node, const DynamicSample& message) {
    if (!message) return fail(Errc::unavailable, "the message did not come");
    const auto payload = std::make_shared<const Payload>(message.cdr().begin(), message.cdr().end());
    for (std::size_t i = 0; i < offer_.fields.size(); ++i) {
      auto echo = Echo::open(node, offer_, i, *type_, payload);
      if (!echo) return tl::unexpected(echo.error());
      echoes_.push_back(*std::move(echo));
    }
    return open_sockets();
  }

  Result<void> open_sockets() {
    for (auto [wanted, kind, server] :
         {std::tuple(offer_.udp, Socket::udp, &udp_), std::tuple(offer_.tcp, Socket::tcp, &tcp_)}) {
      if (!wanted) continue;
      auto opened = FloorServer::open(kind, offer_.session, offer_.answers);
      if (!opened) return tl::unexpected(opened.error());
      *server = *std::move(opened);
    }
    return {};
  }

  const Offer offer_;
  const std::uint64_t side_ = random_number();
  const Usage began_ = usage_now();
  Result<DynamicPublisher> reports_;
  const Result<DynamicType> type_;
  std::optional<DynamicSubscriber> messages_;
  std::vector<std::unique_ptr<Echo>> echoes_;
  std::unique_ptr<FloorServer> udp_, tcp_;
  std::string error_;
  /// The time of the offer, later the time of the beginning or of the error
  std::int64_t since_ns_ = now_ns();
  bool waits_ = true, was_there_ = false, ended_ = false;
  std::uint64_t shown_ = 0;
};

Result<Pong> Pong::open(Node node) {
  SubscriberOptions options{.reliability = reliable, .durability = transient_local};
  options.pollable = true;
  return node.subscriber(offer_topic, text_type(), "*", options).map([&](DynamicSubscriber&& offers) {
    return Pong(node, std::move(offers));
  });
}

Pong::Pong(Node node, DynamicSubscriber offers) : node_(std::move(node)), offers_(std::move(offers)) {}
Pong::Pong(Pong&&) noexcept = default;
Pong::~Pong() = default;

int Pong::descriptor() const { return offers_.file_descriptor(); }

std::chrono::nanoseconds Pong::pause() const {
  const bool waits = std::ranges::any_of(sessions_, [](const auto& session) { return session->waits(); });
  return waits ? 10ms : 1000ms;
}

std::vector<std::string> Pong::step() {
  std::vector<std::string> sentences;
  while (const auto text = take_text(offers_)) {
    std::string sentence = handle(*text);
    if (!sentence.empty()) sentences.push_back(std::move(sentence));
  }
  for (const auto& session : sessions_)
    if (session->begin(node_))
      sentences.push_back(session->error().empty() ? "begins: " + session->name()
                                                   : "cannot take part: " + session->error());
  std::erase_if(sessions_, [&](const auto& session) {
    const bool left = session->is_left();
    if (left && session->is_under_way())
      sentences.push_back("the side that sends is gone: " + session->name());
    return left;
  });
  return sentences;
}

std::string Pong::handle(const std::string& text) {
  const std::optional<Offer> offer = offer_of(text);
  if (!offer) return "an offer of another version of sft perf is left out";
  const auto found =
      std::ranges::find_if(sessions_, [&](const auto& session) { return session->id() == offer->session; });
  if (found == sessions_.end()) {
    if (offer->mark != 0 || offer->ends) return "";  // a run that began before this program
    if (sessions_.size() >= sessions_max) return "too many runs at a time: one is left out";
    sessions_.push_back(std::make_unique<Session>(node_, *offer));
    return "";
  }
  (*found)->report(offer->mark);
  if (!offer->ends) return "";
  const Usage usage = (*found)->usage();
  const std::string sentence = fmt::format(
      "ends: {}: {} received; processor time {}, {} context switches, {} in and {} out at the interfaces, "
      "memory {}",
      (*found)->name(), tool::count_text((*found)->received(), "sample"), tool::duration_text(usage.cpu_s),
      usage.switches, tool::bytes_text(static_cast<double>(usage.bytes_in)),
      tool::bytes_text(static_cast<double>(usage.bytes_out)),
      tool::bytes_text(static_cast<double>(usage.memory_bytes)));
  (*found)->end();
  return sentence;
}

std::string Pong::line() {
  std::uint64_t fresh = 0;
  for (const auto& session : sessions_) fresh += session->fresh();
  return std::ranges::none_of(sessions_, [](const auto& session) { return session->is_under_way(); })
             ? ""
             : fmt::format("{} in the last second", tool::count_text(fresh, "sample"));
}

}  // namespace sft::perf
