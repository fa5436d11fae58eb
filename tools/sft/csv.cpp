#include "tools/sft/csv.h"

#include <nlohmann/json.hpp>

namespace sft::tool {

namespace {

using Member = StructType::Member;

std::string in_cell(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

Result<std::string> cell(const DynamicView& view, const JsonOptions& options) {
  if (view.is_absent()) return std::string();
  Result<std::string> json = to_json(view, options);
  if (!json || !json->starts_with('"')) return json;
  return nlohmann::json::parse(*json).get<std::string>();  // a text, the name of an enumerator, or base64
}

}  // namespace

void CsvTable::add_columns(const StructType& type, const FieldMask& mask, const std::string& prefix,
                           std::size_t leaf) {
  for (const Member& m : type.members) {
    const std::size_t leaves = leaf_count(m);
    const std::string path = prefix + std::string(m.name);
    if (m.kind == Member::Kind::structure && m.shape == Member::Shape::single) {
      add_columns(*m.type, mask, path + ".", leaf);
    } else if (mask.any_of(leaf, leaves)) {
      const bool has_length = m.kind == Member::Kind::structure && m.shape == Member::Shape::sequence;
      columns_.push_back({path, has_length && !mask.any_of(leaf + 1, leaves - 1)});
    }
    leaf += leaves;
  }
}

std::string CsvTable::header() const {
  std::string text;
  for (const Column& column : columns_) {
    if (!text.empty()) text += ',';
    text += in_cell(column.path + (column.only_size ? ".size" : ""));
  }
  return text;
}

Result<std::string> CsvTable::row(const DynamicView& sample, const JsonOptions& options) const {
  std::string text;
  for (const Column& column : columns_) {
    if (&column != &columns_.front()) text += ',';
    const DynamicView view = sample.find(column.path);
    if (view.is_absent()) continue;  // the sample belongs to a selection without this field
    if (column.only_size) {
      const Result<std::size_t> size = view.size();
      if (!size) return tl::unexpected(size.error());
      text += std::to_string(*size);
      continue;
    }
    const Result<std::string> value = cell(view, options);
    if (!value) return value;
    text += in_cell(*value);
  }
  return text;
}

}  // namespace sft::tool
