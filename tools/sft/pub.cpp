#include "tools/sft/pub.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>

#include "tools/sft/documents.h"
#include "tools/sft/message_type.h"
#include "tools/sft/msg_text.h"
#include "tools/terminal/units.h"

namespace sft::tool {

namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr double usual_rate_hz = 1;
constexpr auto most_behind = 20ms;  // samples that are late by more than this are skipped
constexpr auto afterglow = 100ms;   // the time for the last sample to be received before the node closes

/// A message that has been checked. It is encoded once, unless it contains the present time.
class Value {
 public:
  static Result<Value> of(const DynamicType& type, const std::string& text) {
    Result<std::string> json = json_from_yaml(type.type(), text);
    if (!json) return tl::unexpected(json.error());
    const FromJsonOptions now{.now = std::chrono::system_clock::now()};
    return cdr_from_json(type.type(), *json, now).map([&](std::vector<std::byte>&& payload) {
      const bool has_time = json->find("\"now\"") != json->npos || json->find("\"auto\"") != json->npos;
      return Value(has_time ? *std::move(json) : "", std::move(payload));
    });
  }

  Result<PublishStatus> publish(DynamicPublisher& publisher) const {
    return json_.empty() ? publisher.publish_cdr(payload_) : publisher.publish_json(json_);
  }

 private:
  Value(std::string json, std::vector<std::byte> payload)
      : json_(std::move(json)), payload_(std::move(payload)) {}

  std::string json_;
  std::vector<std::byte> payload_;
};

/// The messages of one run, which are returned one by one when they are due.
class Source {
 public:
  Source(const PubOptions& options, DynamicType type, Stop& stop)
      : options_(options), type_(std::move(type)), stop_(stop), documents_(stop) {}

  /// Checks the message of the command line before anything is published.
  Result<void> check() {
    if (from_input()) return {};
    return Value::of(type_, options_.value).map([&](Value&& value) { value_ = std::move(value); });
  }

  /// Waits until the next message is due, and returns it, or null if there is none.
  Result<const Value*> next() {
    if (options_.count != 0 && given_ == options_.count) return nullptr;
    if (from_input()) {
      const auto document = documents_.next();
      if (!document) return nullptr;
      Result<Value> value = Value::of(type_, *document);
      if (!value) {
        return fail(value.error().code,
                    fmt::format("document {} of the input: {}", given_ + 1, value.error().message));
      }
      value_ = *std::move(value);
    }
    if (given_ == 0) due_ = Clock::now();
    if (stop_.wait_for(due_ - Clock::now())) return nullptr;
    due_ = std::max(due_ + period(), Clock::now() - most_behind);
    ++given_;
    return &*value_;
  }

  bool from_input() const { return options_.value == "-"; }

 private:
  std::chrono::nanoseconds period() const {
    if (from_input() && !options_.rate_hz) return 0ns;
    return seconds(1 / options_.rate_hz.value_or(usual_rate_hz));
  }

  const PubOptions& options_;
  DynamicType type_;
  Stop& stop_;
  Documents documents_;
  std::optional<Value> value_;
  Clock::time_point due_{};
  std::uint64_t given_ = 0;
};

std::size_t served(const PublisherStatus& status) {
  return status.vanilla_readers +
         static_cast<std::size_t>(std::ranges::count_if(status.readers, &PublisherStatus::Reader::served));
}

/// Waits until enough subscribers are served, and returns true. Prints the reason and returns false if that
/// does not happen in time.
bool wait_for(std::size_t subscribers, const DynamicPublisher& publisher, const std::string& topic,
              const CommonOptions& common, Session& session) {
  Stop& stop = session.stop();
  const auto end = Clock::now() + seconds(common.timeout_s);
  while (!publisher.wait_for_subscribers(subscribers, 20ms)) {
    if (stop.wait_for(0ns)) return false;
    if (Clock::now() < end) continue;
    const PublisherStatus status = publisher.status();
    std::string text = fmt::format("Nothing was published: {} of {} of '{}' came within {:g} s in domain {}",
                                   served(status), count_text(subscribers, "subscriber"), topic,
                                   common.timeout_s, session.node().status().domain);
    for (const PublisherStatus::Reader& reader : status.readers)
      if (!reader.served) text += fmt::format("; node '{}' is not served: {}", reader.node, reader.reason);
    for (const DomainSnapshot::Pair& pair : session.node().domain().pairs)
      if (pair.publisher == status.id && pair.dds_subscriber && !pair.matched)
        text += "; a reader of DDS is not served: " + printable(pair.reason);
    complain(text + '.');
    return false;
  }
  if (subscribers > 0) await_dds_readers(publisher, stop);
  return true;
}

Result<std::uint64_t> publish_all(Source& source, DynamicPublisher& publisher) {
  for (std::uint64_t published = 0;; ++published) {
    const Result<const Value*> value = source.next();
    if (!value) return tl::unexpected(value.error());
    if (*value == nullptr) return published;
    if (const auto done = (*value)->publish(publisher); !done) return tl::unexpected(done.error());
  }
}

void report(const DynamicPublisher& publisher, const std::string& topic, bool json, Output& output) {
  const PublisherStatus status = publisher.status();
  const std::string type = ros_name(publisher.type().name());
  if (!json) {
    const std::string dropped =
        status.dropped == 0 ? "" : fmt::format(", {} not handed to every reader", status.dropped);
    const std::string text =
        fmt::format("{}: {} of {}{}; {} now", topic, count_text(status.published, "sample"), type, dropped,
                    count_text(served(status), "subscriber"));
    return output.line(output.fitted(text, 4));
  }
  nlohmann::ordered_json readers = nlohmann::ordered_json::array();
  for (const PublisherStatus::Reader& reader : status.readers) {
    readers.push_back({{"node", reader.node},
                       {"served", reader.served},
                       {"transport", reader.served ? nlohmann::ordered_json(to_string(reader.transport))
                                                   : nlohmann::ordered_json()},
                       {"reason", reader.reason},
                       {"sent", reader.sent}});
  }
  output.record({{"topic", topic},
                 {"type", type},
                 {"published", status.published},
                 {"dropped", status.dropped},
                 {"subscribers", std::move(readers)},
                 {"dds_subscribers", status.vanilla_readers}});
}

}  // namespace

ExitCode run(const PubOptions& options, const CommonOptions& common, Session& session) {
  if (const Result<void> sound = session.check_name(options.topic); !sound) return give_up(sound.error());
  const std::string topic = Session::plain_name(options.topic);
  const Result<DynamicType> type = find_message_type(options.type, topic, session);
  if (!type) return give_up(type.error());
  Source source(options, *type, session.stop());
  if (const Result<void> ok = source.check(); !ok) {
    complain(ok.error().message);
    return ExitCode::failed;
  }
  const PublisherOptions qos{.reliability = options.reliable ? reliable : best_effort,
                             .durability = options.transient_local ? transient_local : volatile_};
  Result<DynamicPublisher> publisher = session.node().publisher(topic, *type, qos);
  if (!publisher) return give_up(publisher.error());
  const bool ends = options.count != 0 || source.from_input();
  const std::size_t wanted = options.wait_for.value_or(ends ? 1 : 0);
  if (!wait_for(wanted, *publisher, topic, common, session)) return ExitCode::nothing;
  const Result<std::uint64_t> published = publish_all(source, *publisher);
  if (!published) {
    complain(published.error().message);
    return ExitCode::failed;
  }
  session.stop().wait_for(afterglow);
  report(*publisher, topic, common.json, session.output());
  return *published > 0 ? ExitCode::done : ExitCode::nothing;
}

}  // namespace sft::tool
