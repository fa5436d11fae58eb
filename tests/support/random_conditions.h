// Random conditions on the fields of a type, and random streams of messages and stamps. The streams come
// close to the limits of the conditions: their values are near the constants, and as far from former values
// as the deadbands.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "sft/detail/type_table.h"
#include "sft/selection.h"
#include "sft/type_support.h"
#include "tests/support/gate_reference.h"
#include "tests/support/test_seed.h"

namespace sft::test {

class RandomConditions {
 public:
  using Condition = Selection::Condition;

  /// REQUIRES: the type has a field that is a single value.
  RandomConditions(Random& random, const StructType& type) : random_(random), fields_(single_fields(type)) {}

  const std::vector<SingleField>& fields() const { return fields_; }

  /// Returns conditions of all kinds, up to the number and depth that a selection allows. Often there are
  /// only a few.
  std::vector<Condition> conditions();
  /// Returns the conditions as they are written after the "@" of a selection's text. Randomly adds
  /// parentheses and blanks that are not needed.
  std::string text(const TypeSupport& type, const std::vector<Condition>& conditions);

  /// Changes some single values of a message, and so makes the next message of a stream.
  void change(void* message);
  /// Returns the stamp of the next sample. Mostly the stamp is later, sometimes by exactly the period of a
  /// condition, and sometimes it is earlier.
  std::int64_t stamp_behind(std::int64_t stamp_ns);

  std::uint64_t below(std::uint64_t end) { return random_() % end; }
  bool one_in(std::uint64_t n) { return below(n) == 0; }

 private:
  void add(std::vector<Condition>& to, std::size_t nodes, std::size_t depth);
  Condition condition();
  Selection::Number constant();
  Selection::Number deadband();
  std::uint64_t period_us();
  std::string text(const TypeSupport& type, const std::vector<Condition>& conditions, std::size_t& next,
                   const Condition* parent);
  std::string text_of_comparison(const TypeSupport& type, const Condition& condition);
  std::string text_of_change(const TypeSupport& type, const Condition& condition);
  std::string blank() { return std::string(one_in(8) ? 2 : 1, ' '); }

  double real(double former);
  template <class Integer>
  Integer integer(Integer former, const EnumType* enumeration);
  template <class Integer>
  void change_integer(std::byte* at, const EnumType* enumeration = nullptr);
  template <class Real>
  void change_real(std::byte* at);
  void change_text(std::string& text, std::size_t most);
  void change_field(const SingleField& field, std::byte* at);

  Random& random_;
  std::vector<SingleField> fields_;
  std::vector<Selection::Number> numbers_{};  ///< the numbers in the conditions
  std::vector<std::uint64_t> periods_us_{};   ///< the periods in the conditions, in microseconds
};

}  // namespace sft::test
