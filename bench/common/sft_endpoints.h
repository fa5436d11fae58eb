// Publishers and subscribers of SFT for one type.
#pragma once

#include <sft/sft.h>
#include <algorithm>
#include <chrono>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "bench/common/contender.h"
#include "bench/common/contest.h"

namespace sft::bench {

template <class T>
std::size_t served_by(const Publisher<T>& publisher) {
  const std::vector<PublisherStatus::Reader> readers = publisher.status().readers;
  return static_cast<std::size_t>(std::ranges::count_if(readers, &PublisherStatus::Reader::served));
}

template <class Status>
std::size_t connected_to(const Status& status) {
  return static_cast<std::size_t>(
      std::ranges::count_if(status.writers, &SubscriberStatus::Writer::connected));
}

/// Writes messages in turns. If the message type has a number, the number of the sample is written into it.
template <class T>
class SftWriter : public Writer {
 public:
  SftWriter(Node& node, const std::string& topic, const PublisherOptions& options, std::vector<T> messages)
      : publisher_(node.publisher<T>(topic, options).value()), messages_(std::move(messages)) {}

  std::size_t readers() const override { return served_by(publisher_); }
  bool serves(std::size_t count) const override {
    return publisher_.wait_for_subscribers(count, std::chrono::nanoseconds(0));
  }
  void write(std::uint64_t number) override {
    T& message = messages_[number % messages_.size()];
    if constexpr (has_number) message.number = number;
    publisher_.publish(message);
  }
  void write_together(std::uint64_t first, std::uint64_t count) override {
    if constexpr (has_number) {
      together_.resize(count, messages_.front());
      for (T& m : together_) m.number = first++;
      publisher_.publish(std::span<const T>(together_));
    } else {
      Writer::write_together(first, count);
    }
  }

 private:
  static constexpr bool has_number = requires(T & message) { message.number = 1; };

  Publisher<T> publisher_;
  std::vector<T> messages_;
  std::vector<T> together_;
};

/// Reads the fields `requirement` of messages of type T. Reports the number in the message, or 0 if the
/// message has no number.
template <class T, Req<T> requirement = Req<T>(all<T>)>
class SftReader : public Reader {
 public:
  SftReader(Node& node, const std::string& topic, const SubscriberOptions& options, Arrived arrived)
      : subscriber_((arrived ? node.subscriber<T, requirement>(topic, call(std::move(arrived)), options)
                             : node.subscriber<T, requirement>(topic, options))
                        .value()) {}

  std::size_t writers() const override { return connected_to(subscriber_.status()); }
  void wait() override { subscriber_.wait(std::chrono::seconds(1)); }
  std::uint64_t take() override {
    const auto sample = subscriber_.take();
    return sample ? read(sample) : 0;
  }

 private:
  using Taken = Sample<T, requirement>;

  static auto call(Arrived arrived) {
    return [arrived = std::move(arrived)](const Taken& sample) { arrived(number_of(sample)); };
  }
  static std::uint64_t number_of(const Taken& sample) {
    if constexpr (requires { sample->number(); }) {
      return sample->number();
    } else {
      return 0;
    }
  }
  static std::uint64_t read(const Taken& sample) {
    if constexpr (requires { sample->number(); }) {
      if constexpr (requires { sample->data().back(); }) {
        if (const auto data = sample->data(); !data.empty()) keep(data.back());
      }
      if constexpr (requires { sample->stamp_ns(); }) keep(sample->stamp_ns());
    }
    return number_of(sample);
  }

  Subscriber<T, requirement> subscriber_;
};

}  // namespace sft::bench
