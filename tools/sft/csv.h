// Samples as rows of a table (RFC 4180), with a column for each field that is not in a sequence or array of
// structs. A sequence or array of structs is one cell, with its elements as JSON.
#pragma once

#include <string>
#include <vector>

#include "sft/dynamic_view.h"
#include "sft/json.h"
#include "sft/mask.h"
#include "sft/type_support.h"

namespace sft::tool {

class CsvTable {
 public:
  CsvTable(const TypeSupport& type, const FieldMask& mask) { add_columns(type.type(), mask, "", 0); }

  std::string header() const;
  /// Returns the row without a line break. A field that the sample lacks is an empty cell.
  Result<std::string> row(const DynamicView& sample, const JsonOptions& options) const;

 private:
  void add_columns(const StructType& type, const FieldMask& mask, const std::string& prefix,
                   std::size_t leaf);

  struct Column {
    std::string path;  ///< the path of the field in a view of the sample
    /// True: the column is the length of a sequence of structs, none of whose fields is chosen.
    bool only_size = false;
  };
  std::vector<Column> columns_;
};

}  // namespace sft::tool
