// The publisher and the subscriber that a peer has.
#pragma once

#include <sft/sft.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "tests/pairs/taken.h"
#include "tests/support/pace.h"

namespace sft::test {

/// Events in the order in which they came.
class EventList {
 public:
  Event::Callback callback();
  nlohmann::json to_json() const;

 private:
  mutable std::mutex mutex_;
  nlohmann::json events_ = nlohmann::json::array();
};

/// Publishes message n as its n-th.
class Publishing {
 public:
  Publishing(Node& node, const std::string& topic, const nlohmann::json& options, EventList& events);

  void publish(std::uint64_t count, std::chrono::microseconds period);
  /// Until stop(), on a thread.
  void start(std::chrono::microseconds period);
  void stop() { ticker_.reset(); }
  PublisherStatus status() const { return publisher_.status(); }

 private:
  void publish_next();

  Publisher<PointCloud2> publisher_;
  std::uint64_t published_ = 0;
  std::optional<Ticker> ticker_;  // goes first
};

/// Takes on a thread of its own whatever comes.
class Subscribing {
 public:
  /// `fields`: one of a few masks that are compiled in; "recorded"; "image": another type; "taller": another
  /// definition of the type.
  static std::unique_ptr<Subscribing> open(Node& node, const std::string& topic, const std::string& fields,
                                           const nlohmann::json& options, EventList& events);
  virtual ~Subscribing() = default;

  virtual SubscriberStatus status() const = 0;
  virtual nlohmann::json taken() const = 0;
  virtual void set_max_rate_hz(double max_rate_hz) = 0;
  /// Recorded: which fields are read from now on of each sample, and of the last one that came.
  virtual void read(const std::string& fields) = 0;
};

}  // namespace sft::test
