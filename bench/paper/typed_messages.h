// Messages of one generated type.
#pragma once

#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <utility>

#include "bench/paper/messages.h"
#include "sft/detail/decode.h"
#include "sft/detail/encode.h"

namespace sft::bench::paper {

template <class T>
std::vector<std::byte> encoded(const T& message) {
  const StructType& type = detail::TypeTable<T>::type;
  const FieldMask full = type_support<T>().full();
  const std::uint32_t bytes = detail::encoded_size(type, &message, full).bytes;
  std::vector<std::uint64_t> memory((bytes + 7) / 8);  // for the alignment
  const std::span<std::byte> body = std::as_writable_bytes(std::span(memory)).first(bytes);
  std::vector<std::uint32_t> index(detail::slot_count(type));
  detail::encode(type, &message, full, body, index);
  return {body.begin(), body.end()};
}

/// Nothing if the body is malformed.
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
  explicit TypedMessages(std::vector<T> messages) : messages_(std::move(messages)) {
    for (const T& message : messages_) bodies_.push_back(encoded(message));
  }

  const TypeSupport& type() const override { return type_support<T>(); }

  std::unique_ptr<Writer> publisher(Node& node, const std::string& topic,
                                    const PublisherOptions& options) const override {
    return std::make_unique<TypedWriter>(node.publisher<T>(topic, options).value(), messages_);
  }

  std::size_t masked_bytes(std::size_t number, FieldSet fields) const override {
    return detail::encoded_size(detail::TypeTable<T>::type, &messages_[number],
                                type().closed(mask_of(fields)))
        .bytes;
  }

 private:
  class TypedWriter final : public Writer {
   public:
    TypedWriter(Publisher<T> publisher, const std::vector<T>& messages)
        : publisher_(std::move(publisher)), messages_(messages) {}
    bool serves(std::size_t readers) const override {
      return publisher_.wait_for_subscribers(readers, std::chrono::nanoseconds(0));
    }
    void write(std::size_t number) override { publisher_.publish(messages_[number]); }

   private:
    Publisher<T> publisher_;
    const std::vector<T>& messages_;
  };

  const std::vector<T> messages_;
};

template <class T>
SharedMessages shared(std::vector<T> messages) {
  return std::make_shared<TypedMessages<T>>(std::move(messages));
}

}  // namespace sft::bench::paper
