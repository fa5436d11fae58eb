#include "selection_parser.h"
#include "round_to_nearest.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <utility>

#include "sft/detail/type_table.h"

namespace sft::detail {

namespace {

using Condition = Selection::Condition;

constexpr std::string_view blanks = " \t\r\n";

bool is_word_character(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
}

bool is_blank(char c) { return blanks.find(c) != std::string_view::npos; }

/// Returns the beginning of the text in quotes, for an error of one line.
std::string in_quotes(std::string_view text) {
  std::string shown(text.substr(0, 255));
  std::ranges::replace_if(
      shown, [](char c) { return c < ' ' || c > '~'; }, '?');
  return "'" + shown + "'";
}

/// Appends the scalars of the struct that are in the mask. The first leaf of the struct is `leaf`.
void add_scalars(const StructType& type, std::size_t leaf, const FieldMask& mask,
                 std::vector<std::uint32_t>& to) {
  for (const StructType::Member& member : type.members) {
    const bool is_single = member.shape == Shape::single;
    if (is_single && member.kind == Kind::structure) {
      add_scalars(*member.type, leaf, mask, to);
    } else if (is_single && mask.contains(leaf)) {
      to.push_back(static_cast<std::uint32_t>(leaf));
    }
    leaf += leaf_count(member);
  }
}

double as_double(const Selection::Number& number) {
  return std::visit([](auto value) { return static_cast<double>(value); }, number);
}

}  // namespace

LeafPlace place_of(const StructType& type, std::size_t leaf) {
  bool is_in_collection = false;
  const StructType* within = &type;
  for (;;) {
    const StructType::Member* found = nullptr;
    for (const StructType::Member& member : within->members) {
      if (leaf < leaf_count(member)) {
        found = &member;
        break;
      }
      leaf -= leaf_count(member);
    }
    if (found == nullptr || found->kind != Kind::structure) return {found, is_in_collection};
    is_in_collection = is_in_collection || found->shape != Shape::single;
    if (found->shape == Shape::sequence) {
      if (leaf == 0) return {nullptr, is_in_collection};
      --leaf;
    }
    within = found->type;
  }
}

bool is_scalar(const LeafPlace& place) {
  return place.member != nullptr && place.member->shape == Shape::single && !place.is_in_collection;
}

std::vector<std::uint32_t> scalars_of(const TypeSupport& type, const FieldMask& mask) {
  std::vector<std::uint32_t> scalars;
  add_scalars(type.type(), 0, mask, scalars);
  return scalars;
}

Result<Selection> SelectionParser::parse() {
  for (;;) {
    at_ = std::min(text_.find_first_not_of(", \t\r\n", at_), text_.size());
    if (at_ == text_.size()) return fields();
    if (take("@")) break;
    if (const Result<void> read = item(); !read) return tl::unexpected(read.error());
  }
  const Result<Selection> selection = fields();
  if (!selection) return selection;
  scalars_ = scalars_of(type_, selection->mask());
  const std::size_t begin = at_;
  Result<Selection::Gate> when = gate();
  if (!when) return tl::unexpected(when.error());
  Result<Selection> gated = selection->with_gate(std::move(*when));
  return gated ? std::move(gated) : wrong(begin, gated.error().message, gated.error().code);
}

/// Returns the selection of the text before the gate.
Result<Selection> SelectionParser::fields() {
  std::vector<Selection::Part> parts;
  for (auto& [leaf, wish] : wishes_) {
    if (whole_.contains(leaf)) continue;
    const Result<Selection> alone = Selection::make(type_.none(), {wish.part}, {});
    if (!alone) return wrong(wish.at, alone.error().message, alone.error().code);
    parts.push_back(std::move(wish.part));
  }
  Result<Selection> all = Selection::make(whole_, std::move(parts), {});
  return all ? std::move(all) : wrong(0, all.error().message, all.error().code);
}

/// Adds a part of a leaf to the other parts of that leaf. The text of the part begins at position `at`.
void SelectionParser::add(Selection::Part part, std::size_t at) {
  const auto [found, is_new] = wishes_.try_emplace(part.leaf, Wish{at, part});
  if (is_new) return;
  Selection::Part& both = found->second.part;
  if (both.rows != part.rows || both.columns != part.columns) both.rows = both.columns = {};
  const bool has_channels = !both.channels.empty() && !part.channels.empty();
  if (has_channels) std::ranges::move(part.channels, std::back_inserter(both.channels));
  if (!has_channels) both.channels.clear();
}

/// Takes a path up to the first character that cannot belong to a path. `[]` belongs to a path, and any
/// other `[` does not.
std::string_view SelectionParser::take_path() {
  const std::size_t begin = at_;
  while (at_ < text_.size() &&
         std::string_view(", \t\r\n{}]@();").find(text_[at_]) == std::string_view::npos) {
    if (text_[at_] == '[' && text_.substr(at_, 2) != "[]") break;
    at_ += text_[at_] == '[' ? 2U : 1U;
  }
  return text_.substr(begin, at_ - begin);
}

Result<void> SelectionParser::item() {
  const std::size_t begin = at_;
  const std::string_view path = take_path();
  if (path.empty()) return wrong("here a field is named, not " + in_quotes(text_.substr(at_, 1)));
  const Result<FieldMask> fields = path == "*" ? Result<FieldMask>(type_.full()) : type_.find(path);
  if (!fields) return wrong(begin, fields.error().message, fields.error().code);
  if (next() != '{' && next() != '[') {
    whole_ |= *fields;
    return {};
  }
  const Result<std::uint32_t> leaf = leaf_for_part(*fields, path, begin);
  if (!leaf) return tl::unexpected(leaf.error());
  Selection::Part part{.leaf = *leaf};
  const Layout* const layout = type_.layout_of(*leaf);
  if (layout != nullptr) part.rule = layout->rule;
  const std::size_t of_channels = at_;
  if (take("{")) {
    if (layout == nullptr || !layout->has_channels())
      return wrong(of_channels, in_quotes(path) + " has no channels");
    Result<std::vector<std::string>> names = channels();
    if (!names) return tl::unexpected(names.error());
    part.channels = std::move(*names);
  }
  if (take("[")) {
    const bool has_rows = layout != nullptr && layout->has_rows();
    if (const Result<void> read = window(part, has_rows); !read) return tl::unexpected(read.error());
  }
  add(std::move(part), begin);
  const bool is_apart = at_ == text_.size() || next() == '@' || next() == ',' || is_blank(next());
  return is_apart ? Result<void>() : wrong("behind a part stands a comma or a blank");
}

Result<std::uint32_t> SelectionParser::leaf_for_part(const FieldMask& fields, std::string_view path,
                                                     std::size_t at) const {
  const std::size_t leaf = *fields.begin();
  const LeafPlace place = place_of(type_.type(), leaf);
  if (fields.size() == 1 && place.is_in_collection)
    return wrong(at, in_quotes(path) + " is inside an array or a list; only fields outside these have parts");
  const bool is_field = fields.size() == 1 && place.member != nullptr;
  if (is_field && place.member->shape == Shape::array)
    return wrong(at, in_quotes(path) + " has no parts; an array has a fixed length, and is always whole");
  if (!is_field || place.member->shape != Shape::sequence)
    return wrong(at, in_quotes(path) + " has no parts; only a list of values has some");
  return static_cast<std::uint32_t>(leaf);
}

Result<std::vector<std::string>> SelectionParser::channels() {
  std::vector<std::string> names;
  for (;;) {
    skip_blanks();
    const std::size_t begin = at_;
    while (at_ < text_.size() && text_[at_] != ',' && text_[at_] != '}') ++at_;
    std::string_view name = text_.substr(begin, at_ - begin);
    while (!name.empty() && is_blank(name.back())) name.remove_suffix(1);
    if (name.empty()) return wrong(begin, "here a channel is named");
    names.emplace_back(name);
    if (take("}")) return names;
    if (!take(",")) return wrong("'}' is missing behind the channels");
  }
}

Result<void> SelectionParser::window(Selection::Part& part, bool is_laid_out) {
  bool has_rows = false, has_columns = false;
  for (;;) {
    skip_blanks();
    const std::size_t begin = at_;
    const bool of_rows = take_word("rows");
    const bool of_columns = !of_rows && take_word("columns");
    if ((of_rows || of_columns) && !is_laid_out)
      return wrong(begin, "this field has elements, and no rows and columns; leave out the word");
    bool& known = of_rows ? has_rows : has_columns;
    if (known) return wrong(begin, "this is said already");
    const bool is_named = of_rows || of_columns;
    if (!is_named && has_rows) return wrong("behind rows stand columns: 'columns 1:5'");
    known = true;
    const Result<Selection::Range> read = range();
    if (!read) return tl::unexpected(read.error());
    (of_rows ? part.rows : part.columns) = read->canonical();
    skip_blanks();
    if (take("]")) return {};
    if (!is_named || !take(",")) return wrong("']' is missing behind the part");
  }
}

Result<Selection::Range> SelectionParser::range() {
  Selection::Range range;
  skip_blanks();
  const std::size_t begin = at_;
  bool is_index = false;
  if (next() != ':') {
    const Result<std::uint32_t> first = index();
    if (!first) return tl::unexpected(first.error());
    range.begin = *first;
    is_index = true;
  }
  skip_blanks();
  if (!take(":")) {
    if (is_index) range.end = range.begin + 1;
    return range;
  }
  skip_blanks();
  if (next() >= '0' && next() <= '9') {
    const Result<std::uint32_t> end = index();
    if (!end) return tl::unexpected(end.error());
    range.end = *end;
    if (range.end < range.begin) return wrong(begin, "a range ends behind its begin");
  }
  skip_blanks();
  if (!take(":")) return range;
  skip_blanks();
  const std::size_t of_step = at_;
  const Result<std::uint32_t> step = index();
  if (!step) return tl::unexpected(step.error());
  if (*step == 0) return wrong(of_step, "a step of 0 keeps nothing; steps count from 1");
  range.step = *step;
  return range;
}

Result<std::uint32_t> SelectionParser::index() {
  std::uint32_t value = 0;
  const char* const begin = text_.data() + at_;
  const auto [end, error] = std::from_chars(begin, text_.data() + text_.size(), value);
  if (next() == '-') return wrong("indices count from 0 on, from the front");
  if (end == begin) return wrong("here an index is needed, not " + in_quotes(word()));
  if (error != std::errc() || value == Selection::Range::no_end) return wrong("this index is too large");
  at_ += static_cast<std::size_t>(end - begin);
  return value;
}

Result<Selection::Gate> SelectionParser::gate() {
  Selection::Gate gate;
  skip_blanks();
  if (!take_keyword("at")) {
    Result<Conditions> conditions = series(Condition::Kind::any_of, 1);
    if (!conditions) return tl::unexpected(conditions.error());
    gate.conditions = std::move(*conditions);
    skip_blanks();
    if (at_ == text_.size()) return gate;
    if (!take_word("at")) return wrong("behind a condition stands 'and', 'or' or 'at most'");
  }
  const Result<std::chrono::microseconds> period = least_period();
  if (!period) return tl::unexpected(period.error());
  gate.least_period = *period;
  skip_blanks();
  if (at_ != text_.size()) return wrong("nothing stands behind the rate");
  return gate;
}

/// Parses the text after "at".
Result<std::chrono::microseconds> SelectionParser::least_period() {
  skip_blanks();
  if (!take_word("most")) return wrong("'most' stands behind 'at'");
  skip_blanks();
  if (take_word("one")) {
    skip_blanks();
    if (!take_word("per")) return wrong("'per' stands behind 'one'");
    return duration();
  }
  const std::size_t begin = at_;
  const Result<double> hz = number("a rate").map(as_double);
  if (!hz) return tl::unexpected(hz.error());
  skip_blanks();
  if (!take_word("Hz")) return wrong("behind a rate stands 'Hz'");
  const double us = std::round(1e6 / *hz);
  if (!(us >= 1 && us <= static_cast<double>(Selection::period_max.count())))
    return wrong(begin, "a rate is from one in 24 hours to 1000000 Hz");
  return std::chrono::microseconds(static_cast<std::int64_t>(us));
}

Result<SelectionParser::Conditions> SelectionParser::series(Condition::Kind kind, std::size_t depth) {
  const bool is_any = kind == Condition::Kind::any_of;
  Conditions together{{.kind = kind}};
  do {
    const std::size_t begin = at_;
    Result<Conditions> one = is_any ? series(Condition::Kind::all_of, depth) : term(depth);
    if (!one) return one;
    ++together.front().children;
    together.insert(together.end(), one->begin(), one->end());
    if (together.size() > 2 * Selection::conditions_max)
      return wrong(begin, "more than " + std::to_string(Selection::conditions_max) + " conditions",
                   Errc::limit_exceeded);
    skip_blanks();
  } while (take_word(is_any ? "or" : "and"));
  if (together.front().children == 1) together.erase(together.begin());
  return together;
}

Result<SelectionParser::Conditions> SelectionParser::term(std::size_t depth) {
  skip_blanks();
  if (depth >= Selection::depth_max)
    return wrong("conditions lie at most " + std::to_string(Selection::depth_max) + " deep in each other");
  if (take("(")) {
    Result<Conditions> inner = series(Condition::Kind::any_of, depth + 1);
    if (!inner) return inner;
    skip_blanks();
    if (!take(")")) return wrong("')' is missing");
    return inner;
  }
  const auto as_list = [](Result<Condition> condition) -> Result<Conditions> {
    if (!condition) return tl::unexpected(condition.error());
    return Conditions{std::move(*condition)};
  };
  if (take_keyword("changed")) return as_list(changed());
  if (take_keyword("every")) return as_list(every());
  return as_list(comparison());
}

/// Parses the text after "changed".
Result<Condition> SelectionParser::changed() {
  Condition condition{.kind = Condition::Kind::changed};
  const std::size_t begin = at_;
  if (take("(")) {
    do {
      const Result<std::uint32_t> leaf = scalar();
      if (!leaf) return tl::unexpected(leaf.error());
      condition.leaves.push_back(*leaf);
      if (condition.leaves.size() > Selection::changed_leaves_max)
        return wrong(begin,
                     "'changed' takes at most " + std::to_string(Selection::changed_leaves_max) + " fields");
      skip_blanks();
    } while (take(","));
    if (!take(")")) return wrong("')' is missing");
  } else {
    condition.leaves = scalars_;
    if (scalars_.empty()) return wrong(begin, "no single value is selected; name the fields: changed(a, b)");
    if (scalars_.size() > Selection::changed_leaves_max)
      return wrong(begin, "so many fields are selected that 'changed' needs names: changed(a, b)");
  }
  skip_blanks();
  const bool has_deadband = (next() >= '0' && next() <= '9') || next() == '.' || next() == '-';
  if (!has_deadband) return condition;
  const std::size_t of_number = at_;
  const Result<Selection::Number> deadband = number("a deadband");
  if (!deadband) return tl::unexpected(deadband.error());
  const double size = as_double(*deadband);
  if (size < 0) return wrong(of_number, "a deadband is a finite number from 0 on");
  condition.number = *deadband;
  if (size == 0) condition.number = std::uint64_t{0};
  skip_blanks();
  condition.is_percent = take("%") && size != 0;
  return condition;
}

/// Parses the text after "every".
Result<Condition> SelectionParser::every() {
  const std::size_t begin = at_;
  std::uint64_t count = 0;
  const char* const text = text_.data() + at_;
  const auto [end, error] = std::from_chars(text, text_.data() + text_.size(), count);
  const auto digits = static_cast<std::size_t>(end - text);
  if (error == std::errc() && digits > 0) {
    at_ += digits;
    for (const std::string_view ending : {"st", "nd", "rd", "th"}) {
      if (!take_word(ending)) continue;
      if (count == 0) return wrong(begin, "samples are counted from the 1st on");
      return Condition{.kind = Condition::Kind::nth, .number = count};
    }
    at_ = begin;
  }
  const Result<std::chrono::microseconds> period = duration();
  if (!period) return tl::unexpected(period.error());
  return Condition{.kind = Condition::Kind::elapsed, .number = static_cast<std::uint64_t>(period->count())};
}

Result<Condition> SelectionParser::comparison() {
  using Comparison = Condition::Comparison;
  const Result<std::uint32_t> leaf = scalar();
  if (!leaf) return tl::unexpected(leaf.error());
  Condition condition{.kind = Condition::Kind::compare, .leaves = {*leaf}};
  skip_blanks();
  constexpr std::pair<std::string_view, Comparison> signs[] = {
      {"<=", Comparison::less_or_equal}, {">=", Comparison::greater_or_equal},
      {"==", Comparison::equal},         {"!=", Comparison::not_equal},
      {"<", Comparison::less},           {">", Comparison::greater}};
  const auto sign = std::ranges::find_if(signs, [this](const auto& one) { return take(one.first); });
  if (sign == std::end(signs)) return wrong("behind a field stands <, <=, >, >=, == or !=");
  condition.comparison = sign->second;
  Result<Selection::Number> number = constant(*leaf);
  if (!number) return tl::unexpected(number.error());
  condition.number = *number;
  return condition;
}

Result<std::uint32_t> SelectionParser::scalar() {
  skip_blanks();
  const std::size_t begin = at_;
  while (is_word_character(next()) || next() == '.' || text_.substr(at_, 2) == "[]")
    at_ += next() == '[' ? 2U : 1U;
  const std::string_view path = text_.substr(begin, at_ - begin);
  if (path.empty()) return wrong(begin, "here a condition is needed: a field, 'changed' or 'every'");
  const Result<FieldMask> fields = type_.find(path);
  if (!fields) return wrong(begin, fields.error().message, fields.error().code);
  if (fields->size() != 1 || !is_scalar(place_of(type_.type(), *fields->begin())))
    return wrong(begin, in_quotes(path) + " is not a single value");
  return static_cast<std::uint32_t>(*fields->begin());
}

Result<Selection::Number> SelectionParser::constant(std::uint32_t leaf) {
  skip_blanks();
  const std::size_t begin = at_;
  const StructType::Member& member = *place_of(type_.type(), leaf).member;
  if (member.kind == Kind::string) return wrong(begin, "texts are not compared; use 'changed'");
  const std::string_view name = word();
  if (!name.empty() && (name.front() < '0' || name.front() > '9')) {
    const auto known = [name](const EnumType::Enumerator& e) { return e.name == name; };
    if (member.enumeration != nullptr) {
      const auto found = std::ranges::find_if(member.enumeration->enumerators, known);
      if (found != member.enumeration->enumerators.end()) {
        at_ += name.size();
        return found->value;
      }
    }
    if (member.kind == Kind::boolean && take_word("true")) return std::uint64_t{1};
    if (member.kind == Kind::boolean && take_word("false")) return std::uint64_t{0};
    return wrong(begin, "here a number is needed, not " + in_quotes(name));
  }
  return number("a number");
}

/// Parses a number. The result is an integer if the text is an integer that 64 bits can hold.
Result<Selection::Number> SelectionParser::number(std::string_view what) {
  const char* const text = text_.data() + at_;
  const char* const end = text_.data() + text_.size();
  std::uint64_t natural = 0;
  std::int64_t negative = 0;
  const auto ends_there = [end](const char* at) {
    return at == end || (*at != '.' && *at != 'e' && *at != 'E');
  };
  if (const auto read = std::from_chars(text, end, natural); read.ec == std::errc() && ends_there(read.ptr)) {
    at_ += static_cast<std::size_t>(read.ptr - text);
    return natural;
  }
  if (const auto read = std::from_chars(text, end, negative);
      read.ec == std::errc() && ends_there(read.ptr)) {
    at_ += static_cast<std::size_t>(read.ptr - text);
    return negative;
  }
  const RoundToNearest rounding;
  double value = 0;
  const auto read = std::from_chars(text, end, value);
  if (read.ptr == text) return wrong("here " + std::string(what) + " is needed, not " + in_quotes(word()));
  if (read.ec != std::errc() || !std::isfinite(value))
    return wrong(std::string(what) + " is a finite number");
  at_ += static_cast<std::size_t>(read.ptr - text);
  return value;
}

Result<std::chrono::microseconds> SelectionParser::duration() {
  skip_blanks();
  const std::size_t begin = at_;
  const Result<Selection::Number> count = number("a period");
  if (!count) return tl::unexpected(count.error());
  skip_blanks();
  constexpr std::pair<std::string_view, double> units[] = {{"us", 1}, {"ms", 1e3}, {"s", 1e6}, {"min", 6e7}};
  const auto unit = std::ranges::find_if(units, [this](const auto& one) { return take_word(one.first); });
  if (unit == std::end(units)) return wrong("behind a period stands us, ms, s or min");
  const double us = std::round(as_double(*count) * unit->second);
  if (!(us >= 1 && us <= static_cast<double>(Selection::period_max.count())))
    return wrong(begin, "a period is from 1 us to 24 hours");
  return std::chrono::microseconds(static_cast<std::int64_t>(us));
}

void SelectionParser::skip_blanks() { at_ = std::min(text_.find_first_not_of(blanks, at_), text_.size()); }

bool SelectionParser::take(std::string_view sign) {
  if (text_.substr(at_, sign.size()) != sign) return false;
  at_ += sign.size();
  return true;
}

std::string_view SelectionParser::word() const {
  std::size_t end = at_;
  while (end < text_.size() && is_word_character(text_[end])) ++end;
  return text_.substr(at_, end - at_);
}

bool SelectionParser::take_word(std::string_view wanted) { return word() == wanted && take(wanted); }

bool SelectionParser::take_keyword(std::string_view wanted) {
  const std::size_t begin = at_;
  if (!take_word(wanted)) return false;
  const bool is_in_path = next() == '.' || next() == '[';
  skip_blanks();
  const bool is_field = is_in_path || next() == '<' || next() == '>' || next() == '=' || next() == '!';
  if (is_field) at_ = begin;
  return !is_field;
}

tl::unexpected<Error> SelectionParser::wrong(std::size_t at, std::string message, Errc code) const {
  return fail(code, "column " + std::to_string(at + 1) + ": " + std::move(message));
}

}  // namespace sft::detail
