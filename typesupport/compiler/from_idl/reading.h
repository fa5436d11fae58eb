// The position of the reader, which reports of unsupported definitions name.
#pragma once

#include <stdbool.h>

#include "idl/processor.h"
#include "model.h"

struct sft_reading {
  struct sft_file* file;  ///< the file that is being filled
  const void* node;       ///< reports name its line
  const char* owner;      ///< scoped name of the declaration
  const char* member;     ///< null outside of members
  uint32_t column;        ///< reports name it, too; 0: they do not
  bool is_refused;        ///< set by the first sft_refuse()
};

/// Reports on stderr what is wrong and what to do, as `format` says. Reading goes on, so that one run reports
/// everything unsupported.
void sft_refuse(struct sft_reading* reading, const char* format, ...) __attribute__((format(printf, 2, 3)));

/// The original of `path` if it is a copy (sft_file.copies), otherwise `path`.
const char* sft_original_path(const char* copies, const char* path);

/// True if the main file itself declares `node`, and not a file that it includes.
bool sft_is_of_main_file(const struct sft_file* file, const void* node);

/// Scoped name of a declared node, "::pkg::msg::X".
const char* sft_scoped_name(const void* node);
