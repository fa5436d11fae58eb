// The position of the reader, for error reports.
#pragma once

#include <stdbool.h>

#include "idl/processor.h"
#include "model.h"

struct sft_reading {
  struct sft_file* file;  ///< the file that is being filled
  const void* node;       ///< the node whose line is in reports
  const char* owner;      ///< the scoped name of the declaration
  const char* member;     ///< the name of the member; null outside of members
  uint32_t column;        ///< the column for reports; 0: reports have no column
  bool is_refused;        ///< true after the first sft_refuse()
};

/// Reports an error on stderr, with the text of `format`, which says what is wrong and what to do. Reading
/// continues, so that one run reports all errors.
void sft_refuse(struct sft_reading* reading, const char* format, ...) __attribute__((format(printf, 2, 3)));

/// Returns the original of `path` if it is a copy (sft_file.copies), otherwise `path`.
const char* sft_original_path(const char* copies, const char* path);

/// Returns true if the main file itself declares `node`, and not one of the files that it includes.
bool sft_is_of_main_file(const struct sft_file* file, const void* node);

/// Returns the scoped name of a declared node, "::pkg::msg::X".
const char* sft_scoped_name(const void* node);
