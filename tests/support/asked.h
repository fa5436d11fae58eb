// Evaluates conditions on a stream of messages. Each message is evaluated in two forms: as the program's
// struct, and encoded. The encoded bytes fill their memory exactly, so that a sanitizer notices each read
// outside of these bytes.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

#include "sft/detail/conditions.h"
#include "sft/type_support.h"
#include "tests/support/encoded.h"

namespace sft::test {

/// An encoded sample that fills its memory exactly, with its index.
class ExactSample {
 public:
  /// REQUIRES: the mask is closed.
  ExactSample(const StructType& type, const void* message, const FieldMask& mask)
      : encoded_(type, message, mask), body_(encoded_.bytes()), state_(encoded_.state()) {
    state_.body = body_.data();
  }
  ExactSample(const ExactSample&) = delete;
  ExactSample& operator=(const ExactSample&) = delete;

  const detail::SampleState& state() const { return state_; }
  detail::FieldSource source() const { return detail::FieldSource::of_sample(state_); }

 private:
  Encoded encoded_;
  std::vector<std::byte> body_;
  detail::SampleState state_;
};

/// The conditions of one gate. One copy of the conditions is evaluated on messages, the other copy on
/// encoded samples.
class Asked {
 public:
  using Condition = Selection::Condition;

  Asked(const StructType& type, const std::vector<Condition>& conditions)
      : type_(&type), by_messages_(type, conditions), by_samples_(type, conditions) {
    const Result<void> check = detail::Conditions::check(type, conditions);
    EXPECT_TRUE(check) << check.error().message;
  }

  void begin() {
    by_messages_.begin();
    by_samples_.begin();
  }
  /// Returns true if the conditions hold. The test fails if the message and the encoded sample give different
  /// results.
  bool holds(const void* message, std::int64_t stamp_ns, const FieldMask& mask) {
    const ExactSample sample(*type_, message, mask);
    const bool result = by_messages_.hold(detail::FieldSource::of_message(message), stamp_ns);
    EXPECT_EQ(by_samples_.hold(sample.source(), stamp_ns), result) << "of the encoded sample";
    return result;
  }
  /// Records that the sample of the last call of holds() has passed.
  void passed(const void* message, std::int64_t stamp_ns, const FieldMask& mask) {
    by_messages_.passed(detail::FieldSource::of_message(message), stamp_ns);
    by_samples_.passed(ExactSample(*type_, message, mask).source(), stamp_ns);
  }

 private:
  const StructType* type_;
  detail::Conditions by_messages_;
  detail::Conditions by_samples_;
};

}  // namespace sft::test
