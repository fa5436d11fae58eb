#include "sft/detail/declared_selection.h"

#include <span>
#include <string>
#include <utility>
#include <vector>

namespace sft::detail {

namespace {

Selection::Range range_of(const DeclaredRange& declared) {
  return {.begin = declared.begin,
          .end = declared.end == 0 ? Selection::Range::no_end : declared.end,
          .step = declared.step == 0 ? 1 : declared.step};
}

Selection::Part part_of(const DeclaredPart& declared) {
  Selection::Part part{
      .leaf = declared.leaf, .rows = range_of(declared.rows), .columns = range_of(declared.columns)};
  const std::string_view names = declared.channels.data();  // ends at the NUL after the last comma
  for (std::size_t begin = 0, comma = 0; (comma = names.find(',', begin)) != names.npos; begin = comma + 1)
    part.channels.emplace_back(names.substr(begin, comma - begin));
  return part;
}

}  // namespace

Result<Selection> declared_selection(const FieldMask& mask, const DeclaredParts& parts) {
  std::vector<Selection::Part> declared;
  for (const DeclaredPart& part : parts) {
    if (!part.is_whole()) declared.push_back(part_of(part));
  }
  return Selection::make(mask, std::move(declared), {});
}

Result<Selection> selection_of_text(const TypeSupport& type, const Selection& declared, FieldsOfText fields,
                                    std::string_view text) {
  Result<Selection> named = type.parse_selection(text);
  if (!named || (fields == FieldsOfText::named && !named->mask().empty())) return named;
  const FieldMask all = type.closed(declared).mask();
  if (!all.contains(named->mask())) {
    return fail(Errc::invalid_argument, "'" + std::string(text) +
                                            "' names fields that the subscriber does not declare: " +
                                            type.format_mask(named->mask() - all));
  }
  const std::span<const Selection::Part> named_parts = named->parts();
  std::vector<Selection::Part> parts(named_parts.begin(), named_parts.end());
  for (const Selection::Part& part : declared.parts()) {
    if (!named->mask().contains(part.leaf)) parts.push_back(part);
  }
  return Selection::make(all, std::move(parts), named->gate());
}

}  // namespace sft::detail
