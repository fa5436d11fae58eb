// The encoded form of an owned message.
#pragma once

#include <cassert>
#include <vector>

#include "sft/detail/encode.h"
#include "sft/detail/walk.h"
#include "sft/type_support.h"

namespace sft::test {

/// Aligned memory with an encoded body, its index and its mask.
class Encoded {
 public:
  template <class T>
  explicit Encoded(const T& value, const Mask<T>& mask = all<T>)
      : Encoded(detail::TypeTable<T>::type, &value,
                TypeSupport(detail::TypeTable<T>::type).closed(FieldMask(mask))) {}

  Encoded(const StructType& type, const void* value, FieldMask mask)
      : mask_(std::move(mask)), index_(detail::slot_count(type)) {
    const detail::EncodedSize size = detail::encoded_size(type, value, mask_);
    assert(size.status == detail::EncodeStatus::ok);
    memory_.resize(size.bytes / 8 + 1);
    detail::encode(type, value, mask_, {body(), size.bytes}, index_);
    state_ = {.body = body(), .body_bytes = size.bytes, .index = index_.data(), .mask = &mask_};
  }
  Encoded(const Encoded&) = delete;
  Encoded& operator=(const Encoded&) = delete;

  const detail::SampleState& state() const { return state_; }
  std::byte* body() { return reinterpret_cast<std::byte*>(memory_.data()); }
  std::uint32_t* index() { return index_.data(); }
  std::size_t slots() const { return index_.size(); }
  std::vector<std::byte> bytes() const { return {state_.body, state_.body + state_.body_bytes}; }

 private:
  FieldMask mask_;
  std::vector<std::uint64_t> memory_;
  std::vector<std::uint32_t> index_;
  detail::SampleState state_;
};

}  // namespace sft::test
