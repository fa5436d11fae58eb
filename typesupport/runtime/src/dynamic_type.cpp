#include "sft/dynamic_type.h"

#include <algorithm>
#include <deque>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "description_format.h"
#include "layout/rule.h"
#include "sft/detail/text.h"
#include "sft/detail/type_description.h"
#include "sft/detail/type_shape.h"

namespace sft {

using namespace detail;

namespace {

/// Returns the largest value of an integer kind; 0 for all other kinds.
std::uint64_t largest_value(Kind kind) {
  if (kind < Kind::int8 || kind > Kind::uint64) return 0;
  const bool is_signed =
      kind == Kind::int8 || kind == Kind::int16 || kind == Kind::int32 || kind == Kind::int64;
  return ~std::uint64_t{0} >> (64 - 8 * size_of(kind) + (is_signed ? 1 : 0));
}

bool is_identifier(std::string_view text) {
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  return !text.empty() && is_letter(text[0]) &&
         std::all_of(text.begin(), text.end(), [&](char c) { return is_letter(c) || is_digit(c); });
}

/// Returns true if the text consists of identifiers joined by "::".
bool is_type_name(std::string_view text) {
  for (;;) {
    const std::size_t end = text.find("::");
    if (!is_identifier(text.substr(0, end))) return false;
    if (end == std::string_view::npos) return true;
    text.remove_prefix(end + 2);
  }
}

}  // namespace

/// Owns a type. Names are views of `bytes`. Types and enumerations must not move, since pointers refer to
/// them.
class DynamicType::Storage {
 public:
  explicit Storage(std::span<const std::byte> description) : bytes(description.begin(), description.end()) {}

  const StructType& root() const { return structs.back(); }

  const TypeSupport& support() const {
    std::call_once(flattened_, [this] { support_.emplace(root()); });
    return *support_;
  }

  const std::vector<std::byte> bytes;
  std::vector<std::vector<Enumerator>> enumerators;
  std::vector<EnumType> enumerations;
  std::vector<std::vector<Member>> members;
  std::vector<std::vector<std::uint32_t>> first_leaves;
  std::vector<StructType> structs;
  std::uint64_t hash = 0;

 private:
  mutable std::once_flag flattened_;
  mutable std::optional<TypeSupport> support_;
};

class DynamicType::Parser {
 public:
  Parser(Storage& storage, const DynamicType::Limits& limits) : out_(storage), limits_(limits) {}

  /// Checks the description. Returns nothing if it is valid, otherwise its first error.
  std::optional<Error> run() {
    if (whole()) return std::nullopt;
    if (is_beyond_) return Error{Errc::limit_exceeded, wrong_};
    return Error{Errc::malformed, "byte " + std::to_string(at_) + " of the type description: " + wrong_};
  }

 private:
  /// The size of a struct including all structs in it.
  struct Expanded {
    std::size_t leaves = 0;
    std::size_t members = 0;  ///< the number of members and enumerators
    std::size_t path_bytes = 0;
    std::size_t depth = 1;
  };
  using Names = std::set<std::string_view>;

  bool whole() {
    std::uint8_t version = 0;
    if (!byte(version)) return false;
    if (version != type_description_version) return fail("unknown version " + std::to_string(version));
    std::size_t n = 0;
    if (!count(n, 4, "enumerations")) return false;
    out_.enumerators.reserve(n);
    out_.enumerations.reserve(n);
    while (out_.enumerations.size() < n) {
      if (!enumeration()) return false;
    }
    if (!count(n, 4, "structs")) return false;
    if (n == 0) return fail("no struct");
    out_.members.reserve(n);
    out_.first_leaves.reserve(n);
    out_.structs.reserve(n);
    expanded_.reserve(n);
    while (out_.structs.size() < n) {
      if (!structure()) return false;
    }
    if (at_ != out_.bytes.size()) return fail("bytes are left over");
    if (describe(out_.root()) != out_.bytes) return fail("not in the one order that is allowed");
    out_.hash = structure_hash(out_.root());
    return true;
  }

  bool enumeration() {
    std::string_view name;
    std::uint8_t form = 0;
    std::size_t n = 0;
    if (!type_name(name) || !byte(form)) return false;
    if (form > 1) return fail("'" + std::string(name) + "' is neither enumeration nor bitmask");
    if (!count(n, 2, "enumerators")) return false;
    if (n == 0) return fail("'" + std::string(name) + "' has no enumerators");
    std::vector<Enumerator>& enumerators = out_.enumerators.emplace_back();
    enumerators.reserve(n);
    Names names;
    for (std::size_t i = 0; i < n; ++i) {
      Enumerator e{};
      if (!identifier(e.name, names) || !number(e.value, UINT64_MAX, "value")) return false;
      if (form == 1 && !is_flag(e.value)) return fail("'" + std::string(e.name) + "' is not one bit");
      enumerators.push_back(e);
    }
    out_.enumerations.push_back({name, form == 1, enumerators});
    return true;
  }

  static bool is_flag(std::uint64_t value) { return value != 0 && (value & (value - 1)) == 0; }

  bool structure() {
    std::string_view name;
    std::size_t n = 0;
    if (!type_name(name) || !count(n, 3, "members")) return false;
    if (n == 0) return fail("'" + std::string(name) + "' has no members");
    struct_ = name;
    std::vector<Member>& members = out_.members.emplace_back();
    members.reserve(n);
    std::vector<std::uint32_t>& first_leaves = out_.first_leaves.emplace_back();
    first_leaves.reserve(n);
    Expanded sum;
    Names names;
    for (std::size_t i = 0; i < n; ++i) {
      Member& m = members.emplace_back();
      first_leaves.push_back(static_cast<std::uint32_t>(sum.leaves));
      if (!member(m, names) || !add(m, sum)) return false;
    }
    expanded_.push_back(sum);
    out_.structs.emplace_back(name, members).first_leaves = first_leaves;
    return layouts(out_.structs.back());
  }

  bool layouts(const StructType& type) {
    std::deque<layout::Rule> read;
    std::vector<layout::RuleOfMember> rules;
    for (std::size_t i = 0; i < type.members.size(); ++i) {
      const Member& m = type.members[i];
      if (m.layout.empty()) continue;
      auto rule = layout::read_rule(m.layout);
      if (!rule) return fail("the layout of " + of(m) + ": " + rule.error().text);
      if (rule->text() != m.layout) return fail("the layout of " + of(m) + " is not in its one spelling");
      rules.push_back({i, &read.emplace_back(*std::move(rule))});
    }
    const auto wrong = layout::check_rules(layout::SeenStructTypes(), &type, rules);
    return !wrong || fail("the layout of " + of(type.members[wrong->member]) + ": " + wrong->text);
  }

  bool member(Member& m, Names& names) {
    std::uint8_t form = 0;
    if (!byte(form)) return false;
    const unsigned kind = form & description::kind_bits;
    const unsigned shape = form >> description::shape_shift & description::shape_bits;
    if (kind > static_cast<unsigned>(Kind::structure)) return fail("unknown kind " + std::to_string(kind));
    if (shape > static_cast<unsigned>(Shape::sequence)) return fail("unknown shape " + std::to_string(shape));
    m.kind = static_cast<Kind>(kind);
    m.shape = static_cast<Shape>(shape);
    m.key = (form & description::is_key) != 0;
    if (!identifier(m.name, names)) return false;
    if (m.shape == Shape::array && !positive(m.count, limits_.array_elements, "elements of an array")) {
      return false;
    }
    if (m.kind == Kind::structure) {
      std::uint64_t type = 0;
      if (!number(type, UINT64_MAX, "struct")) return false;
      if (type >= out_.structs.size()) return fail(of(m) + " is of a struct that is not an earlier one");
      m.type = &out_.structs[type];
    }
    return (form & description::has_attributes) == 0 || attributes(m);
  }

  bool attributes(Member& m) {
    std::uint8_t given = 0;
    if (!byte(given)) return false;
    if (given == 0 || given > description::attribute_bits) return fail(of(m) + " has unknown attributes");
    if ((given & description::has_bound) != 0) {
      if (m.shape != Shape::sequence) return fail(of(m) + " has a bound but is no sequence");
      if (!positive(m.bound, UINT32_MAX, "bound")) return false;
    }
    if ((given & description::has_string_bound) != 0) {
      if (m.kind != Kind::string) return fail(of(m) + " has a string's bound but is none");
      if (!positive(m.string_bound, UINT32_MAX, "bound")) return false;
    }
    if ((given & description::has_enumeration) != 0 && !enumeration_of(m)) return false;
    if ((given & description::has_unit) != 0) {
      if (!text(m.unit)) return false;
      if (m.unit.empty() || !is_printable(m.unit)) return fail(of(m) + " has a unit that cannot be printed");
    }
    if ((given & description::has_layout) == 0) return true;
    return text(m.layout) && (!m.layout.empty() || fail(of(m) + " has a layout without roles"));
  }

  bool enumeration_of(Member& m) {
    std::uint64_t i = 0;
    if (!number(i, UINT64_MAX, "enumeration")) return false;
    if (i >= out_.enumerations.size()) return fail(of(m) + " is of an enumeration that there is not");
    m.enumeration = &out_.enumerations[i];
    const auto& enumerators = out_.enumerators[i];
    const auto largest =
        std::max_element(enumerators.begin(), enumerators.end(),
                         [](const Enumerator& a, const Enumerator& b) { return a.value < b.value; });
    if (largest_value(m.kind) == 0) return fail(of(m) + " is of an enumeration but no integer");
    return largest->value <= largest_value(m.kind) || fail(of(m) + " is too small for its enumerators");
  }

  /// Adds the size of a member. Every sum is checked against the limits, so that sums cannot overflow.
  bool add(const Member& m, Expanded& sum) {
    Expanded inner{.leaves = 1, .members = 0, .path_bytes = 0, .depth = 0};
    if (m.type != nullptr) inner = expanded_[static_cast<std::size_t>(m.type - out_.structs.data())];
    const std::size_t leaves = inner.leaves + (m.type != nullptr && m.shape == Shape::sequence ? 1 : 0);
    sum.leaves += leaves;
    sum.members += 1 + inner.members + (m.enumeration == nullptr ? 0 : m.enumeration->enumerators.size());
    sum.path_bytes += inner.path_bytes + leaves * (m.name.size() + 3);
    sum.depth = std::max(sum.depth, inner.depth + 1);
    if (sum.leaves > limits_.leaves) return beyond(m, limits_.leaves, "fields");
    if (sum.members > limits_.members) return beyond(m, limits_.members, "members and enumerators");
    if (sum.path_bytes > limits_.path_bytes) return beyond(m, limits_.path_bytes, "bytes of paths");
    return sum.depth <= limits_.depth || beyond(m, limits_.depth, "structs in one another");
  }

  // ---- parts of a description ----

  bool byte(std::uint8_t& value) {
    if (at_ == out_.bytes.size()) return fail("it ends too early");
    value = std::to_integer<std::uint8_t>(out_.bytes[at_++]);
    return true;
  }

  bool number(std::uint64_t& value, std::uint64_t most, const char* what) {
    value = 0;
    for (unsigned shift = 0; shift < 64; shift += 7) {
      std::uint8_t next = 0;
      if (!byte(next)) return false;
      const std::uint64_t bits = next & 0x7fU;
      if (bits << shift >> shift != bits) break;
      value |= bits << shift;
      if (next < 0x80) return value <= most || fail(std::string(what) + ": " + std::to_string(value));
    }
    return fail(std::string(what) + ": a number of more than 64 bits");
  }

  bool positive(std::uint32_t& value, std::uint32_t most, const char* what) {
    std::uint64_t n = 0;
    if (!number(n, most, what)) return false;
    value = static_cast<std::uint32_t>(n);
    return n != 0 || fail(std::string(what) + ": 0");
  }

  /// Reads a number of items of at least `least_bytes_each`. Refuses a number that the remaining bytes cannot
  /// hold.
  bool count(std::size_t& n, std::size_t least_bytes_each, const char* what) {
    std::uint64_t value = 0;
    if (!number(value, UINT64_MAX, what)) return false;
    n = static_cast<std::size_t>(value);
    return value <= (out_.bytes.size() - at_) / least_bytes_each ||
           fail(std::to_string(value) + " " + what + " do not fit into the bytes that are left");
  }

  bool text(std::string_view& text) {
    std::size_t n = 0;
    if (!count(n, 1, "characters")) return false;
    if (n > limits_.name_bytes) return fail("a name of " + std::to_string(n) + " bytes");
    text = {reinterpret_cast<const char*>(out_.bytes.data() + at_), n};
    at_ += n;
    return true;
  }

  bool identifier(std::string_view& name, Names& others) {
    if (!text(name)) return false;
    if (!is_identifier(name)) return fail("a name that is no identifier");
    return others.insert(name).second || fail("two are named '" + std::string(name) + "'");
  }

  bool type_name(std::string_view& name) {
    if (!text(name)) return false;
    if (!is_type_name(name)) return fail("the name of a type is not identifiers joined by '::'");
    return type_names_.insert(name).second || fail("two types are named '" + std::string(name) + "'");
  }

  static std::string of(const Member& m) { return "member '" + std::string(m.name) + "'"; }

  bool beyond(const Member& m, std::size_t limit, const char* what) {
    is_beyond_ = true;
    return fail("'" + std::string(struct_) + "' has, with " + of(m) + ", more than " + std::to_string(limit) +
                " " + what + ": only programs that are compiled with the type can use it");
  }

  bool fail(std::string what) {
    wrong_ = std::move(what);
    return false;
  }

  Storage& out_;
  const DynamicType::Limits& limits_;
  std::size_t at_ = 0;
  std::vector<Expanded> expanded_;  // sizes of the structs read so far
  Names type_names_;
  std::string_view struct_;  // name of the struct that is being read
  std::string wrong_;
  bool is_beyond_ = false;  // true if the type is valid, but exceeds a limit
};

Result<DynamicType> DynamicType::parse(std::span<const std::byte> description,
                                       const DynamicType::Limits& limits) {
  if (description.size() > limits.bytes) {  // checked first, so that no copy of a longer description is made
    return fail(Errc::limit_exceeded,
                "the type has a description of " + std::to_string(description.size()) + " bytes, and " +
                    std::to_string(limits.bytes) +
                    " are allowed: only programs that are compiled with the type can use "
                    "it");
  }
  const auto storage = std::make_shared<Storage>(description);
  if (const auto wrong = Parser(*storage, limits).run()) return tl::unexpected(*wrong);
  return DynamicType(storage);
}

const StructType& DynamicType::type() const { return storage_->root(); }
std::uint64_t DynamicType::hash() const { return storage_->hash; }
const TypeSupport& DynamicType::support() const { return storage_->support(); }
std::span<const std::byte> DynamicType::description() const { return storage_->bytes; }

}  // namespace sft
