// Messages that all contenders send, both as messages of SFT and as the same messages in CDR.
#pragma once

#include <sft/sft.h>
#include <algorithm>
#include <cstddef>
#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "bench/common/contender.h"
#include "bench/common/sft_endpoints.h"
#include "sft/detail/decode.h"
#include "sft/detail/encode.h"

struct dds_topic_descriptor;

namespace sft::bench {

/// Messages of one type, which are sent in turns. The object is immutable.
class Messages {
 public:
  explicit Messages(const dds_topic_descriptor& cyclone_type) : cyclone_type_(cyclone_type) {}
  virtual ~Messages() = default;
  Messages(const Messages&) = delete;
  Messages& operator=(const Messages&) = delete;

  virtual const TypeSupport& type() const = 0;
  const dds_topic_descriptor& cyclone_type() const { return cyclone_type_; }
  /// Opens SFT's publisher of these messages.
  virtual std::unique_ptr<Writer> writer(Node& node, const std::string& topic,
                                         const PublisherOptions& options) const = 0;
  /// Opens SFT's subscriber to all fields of such messages.
  virtual std::unique_ptr<Reader> reader(Node& node, const std::string& topic,
                                         const SubscriberOptions& options, Arrived arrived) const = 0;
  /// Returns the size of the CDR of the message with this number in bytes if only the fields `fields` are
  /// sent.
  virtual std::size_t masked_bytes(std::size_t number, FieldSet fields) const = 0;

  /// Returns the bodies of the messages in CDR, without encapsulation, with all fields.
  const std::vector<std::vector<std::byte>>& bodies() const { return bodies_; }
  std::size_t size() const { return bodies_.size(); }
  /// Returns the number of bytes of the longest body.
  std::size_t largest() const;

  FieldSet all() const { return all_fields(type().type().members.size()); }
  /// Returns the fields as a mask, or as text for Node::subscriber().
  FieldMask mask_of(FieldSet fields) const;
  std::string text_of(FieldSet fields) const { return type().format_mask(mask_of(fields)); }
  /// Returns the fields with these names.
  FieldSet named(const std::vector<std::string>& names) const;

 protected:
  std::vector<std::vector<std::byte>> bodies_;

 private:
  const dds_topic_descriptor& cyclone_type_;
};

using SharedMessages = std::shared_ptr<const Messages>;

template <class T>
std::vector<std::byte> encoded(const T& message) {
  const StructType& type = detail::TypeTable<T>::type;
  const FieldMask full = type_support<T>().full();
  const std::uint32_t bytes = detail::encoded_size(type, &message, full).bytes;
  // The memory consists of words of 8 bytes, so that it has the alignment of a body.
  std::vector<std::uint64_t> memory((bytes + 7) / 8);
  const std::span<std::byte> body = std::as_writable_bytes(std::span(memory)).first(bytes);
  std::vector<std::uint32_t> index(detail::slot_count(type));
  detail::encode(type, &message, full, body, index);
  return {body.begin(), body.end()};
}

/// Decodes a body. Returns the message; nothing if the body is malformed.
template <class T>
std::optional<T> decoded(std::span<const std::byte> body) {
  const FieldMask full = type_support<T>().full();
  std::vector<std::uint64_t> memory((body.size() + 7) / 8);
  std::memcpy(memory.data(), body.data(), body.size());
  const detail::SampleState state{.body = reinterpret_cast<const std::byte*>(memory.data()),
                                  .body_bytes = static_cast<std::uint32_t>(body.size()),
                                  .mask = &full};
  T message;
  const auto status = detail::decode(state, detail::TypeTable<T>::type, &message);
  return status == detail::WalkStatus::ok ? std::optional(std::move(message)) : std::nullopt;
}

template <class T>
class TypedMessages final : public Messages {
 public:
  TypedMessages(std::vector<T> messages, const dds_topic_descriptor& cyclone_type)
      : Messages(cyclone_type), messages_(std::move(messages)) {
    for (const T& message : messages_) bodies_.push_back(encoded(message));
  }

  const TypeSupport& type() const override { return type_support<T>(); }
  std::unique_ptr<Writer> writer(Node& node, const std::string& topic,
                                 const PublisherOptions& options) const override {
    return std::make_unique<SftWriter<T>>(node, topic, options, messages_);
  }
  std::unique_ptr<Reader> reader(Node& node, const std::string& topic, const SubscriberOptions& options,
                                 Arrived arrived) const override {
    return std::make_unique<SftReader<T>>(node, topic, options, std::move(arrived));
  }
  std::size_t masked_bytes(std::size_t number, FieldSet fields) const override {
    return detail::encoded_size(detail::TypeTable<T>::type, &messages_[number],
                                type().closed(mask_of(fields)))
        .bytes;
  }

 private:
  const std::vector<T> messages_;
};

template <class T>
SharedMessages shared(std::vector<T> messages, const dds_topic_descriptor& cyclone_type) {
  return std::make_shared<TypedMessages<T>>(std::move(messages), cyclone_type);
}

}  // namespace sft::bench
