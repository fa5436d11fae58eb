// The messages that a publisher of either contender sends.
#pragma once

#include <sft/sft.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "bench/common/cyclone.h"

namespace sft::bench {

/// The publisher of a message of SFT.
struct Sender {
  std::function<bool(std::size_t readers)> serves;
  std::function<void()> send;
};

/// One message, which both contenders send again and again. It is made where it is sent.
struct Payload {
  std::function<Sender(Node& node, const std::string& topic, const PublisherOptions& options)> sft;
  const dds_topic_descriptor_t* cyclone_type;
  std::function<std::shared_ptr<void>()> cyclone;
  std::size_t sample_bytes;  ///< in CDR, within a hundredth of a large one
  bool reliable = false;
  std::size_t sample_bytes_max = PublisherOptions{}.max_sample_bytes;
};

template <class Message>
Sender sender_of(Message message, Node& node, const std::string& topic, const PublisherOptions& options) {
  const auto publisher =
      std::make_shared<Publisher<Message>>(node.publisher<Message>(topic, options).value());
  return {[publisher](std::size_t readers) {
            return publisher->wait_for_subscribers(readers, std::chrono::nanoseconds(0));
          },
          [publisher, message = std::move(message)] { publisher->publish(message); }};
}

Payload cloud_payload(std::size_t data_bytes);
/// A message of so many bytes in CDR, which is sent reliably.
Payload bulk_payload(std::size_t bytes);

/// A message of plain numbers, all 0.
template <class Message, class CycloneMessage>
Payload zeros_payload(const dds_topic_descriptor_t& type) {
  return {.sft = [](Node& node, const std::string& topic,
                    const PublisherOptions& options) { return sender_of(Message{}, node, topic, options); },
          .cyclone_type = &type,
          .cyclone = [] { return std::make_shared<CycloneMessage>(); },
          .sample_bytes = sizeof(CycloneMessage)};
}

}  // namespace sft::bench
