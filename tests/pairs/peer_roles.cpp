#include "tests/pairs/peer_roles.h"

#include <atomic>
#include <sensor_msgs/msg/Image.hpp>
#include <stdexcept>
#include <thread>
#include <vector>

#include "sft/detail/type_description.h"
#include "tests/pairs/status_json.h"

namespace sft::test {

using namespace detail;
using nlohmann::json;
using F = PointCloud2::Field;
using namespace std::chrono_literals;

namespace {

TransportChoice transport_of(const json& options) {
  const std::string name = options.value("transport", "automatic");
  return name == "shm"   ? TransportChoice::shm
         : name == "udp" ? TransportChoice::udp
                         : TransportChoice::automatic;
}

std::chrono::milliseconds duration_of(const json& options, const char* name) {
  return std::chrono::milliseconds(options.value(name, 0));
}

/// Returns the policies that publishers and subscribers have in common.
template <class Options>
Options policies(const json& asked, EventList& events) {
  Options options;
  options.transport = transport_of(asked);
  if (asked.value("reliable", false)) options.reliability = reliable;
  if (asked.value("transient_local", false)) options.durability = transient_local;
  if (asked.value("manual_by_topic", false)) options.liveliness = manual_by_topic;
  options.deadline = duration_of(asked, "deadline_ms");
  options.liveliness_lease = duration_of(asked, "lease_ms");
  options.on_event = events.callback();
  return options;
}

PublisherOptions publisher_options(const json& asked, EventList& events) {
  auto options = policies<PublisherOptions>(asked, events);
  options.history_depth = asked.value("history_depth", 1U);
  return options;
}

SubscriberOptions subscriber_options(const json& asked, EventList& events) {
  auto options = policies<SubscriberOptions>(asked, events);
  options.depth = asked.value("depth", 256U);
  options.max_rate_hz = asked.value("max_rate_hz", 0.0);
  options.recording = {.learn_samples = 1, .narrow_after_samples = asked.value("narrow_after", 5U)};
  return options;
}

template <class T>
T checked(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message);
  return std::move(*result);
}

/// Returns another definition of PointCloud2, with a wider height.
DynamicType taller() {
  const auto& ours = TypeTable<PointCloud2>::members;
  std::vector<Member> members(ours.begin(), ours.end());
  members[1].kind = Kind::uint64;
  return checked(DynamicType::parse(describe(StructType(TypeTable<PointCloud2>::type.name, members))));
}

void read_fields(const Sample<PointCloud2, recorded>& sample, const FieldMask& fields) {
  if (fields.contains(F::header.frame_id)) (void)sample->header().frame_id();
  if (fields.contains(F::height)) (void)sample->height();
  if (fields.contains(F::width)) (void)sample->width();
  if (fields.contains(F::data)) (void)sample->data();
  if (fields.contains(F::is_dense)) (void)sample->is_dense();
}

template <Req<PointCloud2> R>
class Taking final : public Subscribing {
 public:
  explicit Taking(Subscriber<PointCloud2, R> subscriber)
      : subscriber_(std::move(subscriber)), thread_([this] { take_until_ended(); }) {}
  ~Taking() override {
    ended_ = true;
    thread_.join();
  }

  SubscriberStatus status() const override { return subscriber_.status(); }
  json taken() const override { return taken_.to_json(); }
  void set_max_rate_hz(double max_rate_hz) override {
    if (const auto set = subscriber_.set_max_rate_hz(max_rate_hz); !set)
      throw std::runtime_error(set.error().message);
  }
  void read(const std::string& fields) override {
    const std::scoped_lock lock(mutex_);
    fields_ = checked(subscriber_.type().parse_mask(fields));
    if constexpr (R.is_recorded) {
      if (last_) read_fields(last_, fields_);
    }
  }

 private:
  void take_until_ended() {
    while (!ended_) {
      if (!subscriber_.wait(20ms)) continue;
      while (auto sample = subscriber_.take()) use(std::move(sample));
    }
  }
  void use(Sample<PointCloud2, R> sample) {
    taken_.note(sample);
    const std::scoped_lock lock(mutex_);
    if constexpr (R.is_recorded) {
      read_fields(sample, fields_);
      last_ = std::move(sample);
    }
  }

  Subscriber<PointCloud2, R> subscriber_;
  Taken taken_;
  std::mutex mutex_;
  FieldMask fields_ = type_support<PointCloud2>().none();
  Sample<PointCloud2, R> last_;
  std::atomic<bool> ended_{false};
  std::thread thread_;
};

/// A subscriber with another type than the publisher has. No sample must arrive at it.
template <class S>
class Mismatched final : public Subscribing {
 public:
  explicit Mismatched(S subscriber) : subscriber_(std::move(subscriber)) {}
  SubscriberStatus status() const override { return subscriber_.status(); }
  json taken() const override { return subscriber_.take() ? json{"a sample"} : json::array(); }
  void set_max_rate_hz(double) override {}
  void read(const std::string&) override {}

 private:
  mutable S subscriber_;
};
template <class S>
Mismatched(S) -> Mismatched<S>;

}  // namespace

Event::Callback EventList::callback() {
  return [this](const Event& event) {
    const std::scoped_lock lock(mutex_);
    events_.push_back(test::to_json(event));
  };
}

json EventList::to_json() const {
  const std::scoped_lock lock(mutex_);
  return events_;
}

Publishing::Publishing(Node& node, const std::string& topic, const json& options, EventList& events)
    : publisher_(checked(node.publisher<PointCloud2>(topic, publisher_options(options, events)))) {}

void Publishing::publish_next() { publisher_.publish(message(++published_)); }

void Publishing::publish(std::uint64_t count, std::chrono::microseconds period) {
  Pace pace(period);
  for (std::uint64_t i = 0; i < count; ++i) {
    publish_next();
    pace.await_turn();
  }
}

void Publishing::start(std::chrono::microseconds period) {
  stop();
  ticker_.emplace(period, [this](std::uint32_t) { publish_next(); });
}

std::unique_ptr<Subscribing> Subscribing::open(Node& node, const std::string& topic,
                                               const std::string& fields, const json& asked,
                                               EventList& events) {
  const SubscriberOptions options = subscriber_options(asked, events);
  const auto taking = [&]<Req<PointCloud2> R>() -> std::unique_ptr<Subscribing> {
    return std::make_unique<Taking<R>>(checked(node.subscriber<PointCloud2, R>(topic, options)));
  };
  const auto mismatched = [](auto subscriber) -> std::unique_ptr<Subscribing> {
    return std::make_unique<Mismatched<decltype(subscriber)>>(std::move(subscriber));
  };
  if (fields == "recorded") return taking.template operator()<recorded>();
  if (fields == "*") return taking.template operator()<all<PointCloud2>>();
  if (fields == "height, width") return taking.template operator()<F::height | F::width>();
  if (fields == "data") return taking.template operator()<F::data>();
  if (fields == "header") return taking.template operator()<F::header>();
  if (fields == "image") return mismatched(checked(node.subscriber<sensor_msgs::msg::Image>(topic, options)));
  if (fields == "taller") return mismatched(checked(node.subscriber(topic, taller(), "*", options)));
  throw std::runtime_error("no such subscriber: " + fields);
}

}  // namespace sft::test
