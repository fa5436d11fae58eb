// The publisher and the subscriber of a peer.
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

/// Events in the order of their arrival.
class EventList {
 public:
  Event::Callback callback();
  nlohmann::json to_json() const;

 private:
  mutable std::mutex mutex_;
  nlohmann::json events_ = nlohmann::json::array();
};

/// A publisher. Its n-th sample is message n.
class Publishing {
 public:
  Publishing(Node& node, const std::string& topic, const nlohmann::json& options, EventList& events);

  void publish(std::uint64_t count, std::chrono::microseconds period);
  /// Publishes on a thread until stop().
  void start(std::chrono::microseconds period);
  void stop() { ticker_.reset(); }
  PublisherStatus status() const { return publisher_.status(); }

 private:
  void publish_next();

  Publisher<PointCloud2> publisher_;
  std::uint64_t published_ = 0;
  std::optional<Ticker> ticker_;  // destroyed first, so that its thread stops using the other members
};

/// A subscriber, which takes all samples on its own thread.
class Subscribing {
 public:
  /// Opens a subscriber. `fields` is one of a few masks that are known at compile time, "recorded", "image"
  /// (another type), or "taller" (another definition of the type).
  static std::unique_ptr<Subscribing> open(Node& node, const std::string& topic, const std::string& fields,
                                           const nlohmann::json& options, EventList& events);
  virtual ~Subscribing() = default;

  virtual SubscriberStatus status() const = 0;
  virtual nlohmann::json taken() const = 0;
  virtual void set_max_rate_hz(double max_rate_hz) = 0;
  /// Sets the fields that a recorded subscriber reads from each later sample, and from the last one that
  /// arrived.
  virtual void read(const std::string& fields) = 0;
};

}  // namespace sft::test
