// Reads the text of a selection (selection.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sft/selection.h"
#include "sft/type_support.h"

namespace sft::detail {

/// The member of a leaf, and a flag that says if the leaf is in a collection. The leaf for the length of a
/// sequence of structs has no member: null.
struct LeafPlace {
  const StructType::Member* member = nullptr;
  bool is_in_collection = false;  ///< true for an element of an array or a sequence of structs
};
LeafPlace place_of(const StructType& type, std::size_t leaf);

/// Returns true for a number, a boolean, an enumeration or a string that is not in an array or a sequence.
bool is_scalar(const LeafPlace& place);

/// Returns the scalars among the leaves of `mask`: the condition `changed` without names refers to them.
std::vector<std::uint32_t> scalars_of(const TypeSupport& type, const FieldMask& mask);

class SelectionParser {
 public:
  SelectionParser(const TypeSupport& type, std::string_view text)
      : type_(type), text_(text), whole_(type.none()) {}

  /// Parses the text. Errors begin with the column, from 1, of the mistake.
  Result<Selection> parse();

 private:
  using Condition = Selection::Condition;
  using Conditions = std::vector<Condition>;

  /// The requested part of a leaf, and its position in the text.
  struct Wish {
    std::size_t at = 0;
    Selection::Part part;
  };

  Result<void> item();
  void add(Selection::Part part, std::size_t at);
  Result<Selection> fields();
  Result<std::vector<std::string>> channels();
  Result<void> window(Selection::Part& part, bool is_laid_out);
  Result<Selection::Range> range();
  Result<std::uint32_t> index();
  Result<std::uint32_t> leaf_for_part(const FieldMask& fields, std::string_view path, std::size_t at) const;
  Result<Selection::Gate> gate();
  Result<Conditions> series(Condition::Kind kind, std::size_t depth);
  Result<Conditions> term(std::size_t depth);
  Result<Condition> changed();
  Result<Condition> every();
  Result<Condition> comparison();
  Result<std::uint32_t> scalar();
  Result<Selection::Number> constant(std::uint32_t leaf);
  Result<Selection::Number> number(std::string_view what);
  Result<std::chrono::microseconds> duration();
  Result<std::chrono::microseconds> least_period();

  void skip_blanks();
  char next() const { return at_ < text_.size() ? text_[at_] : '\0'; }
  bool take(std::string_view sign);
  bool take_word(std::string_view word);
  /// Takes the word and the blanks after it. Does not take the word if an operator or the rest of a path
  /// follows, because the word is then a field.
  bool take_keyword(std::string_view word);
  std::string_view word() const;
  std::string_view take_path();
  tl::unexpected<Error> wrong(std::size_t at, std::string message, Errc code = Errc::invalid_argument) const;
  tl::unexpected<Error> wrong(std::string message) const { return wrong(at_, std::move(message)); }

  const TypeSupport& type_;
  const std::string_view text_;
  std::size_t at_ = 0;
  FieldMask whole_;                         ///< fields that were named without parts
  std::map<std::uint32_t, Wish> wishes_{};  ///< the requested parts, by leaf
  std::vector<std::uint32_t> scalars_{};    ///< the scalars of all selected fields
};

}  // namespace sft::detail
