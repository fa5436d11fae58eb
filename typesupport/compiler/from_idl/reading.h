// Where the reader is, so that whatever finds something unsupported can name it.
#pragma once

#include <stdbool.h>

#include "idl/processor.h"
#include "model.h"

struct sft_reading {
  struct sft_file* file;  ///< being filled
  const void* node;       ///< whose line messages name
  const char* owner;      ///< scoped name of the declaration
  const char* member;     ///< null outside of members
  bool is_refused;        ///< set by the first sft_refuse()
};

/// Reports on stderr, `format` saying what is wrong and what to do, and goes on: one run names everything
/// unsupported.
void sft_refuse(struct sft_reading* reading, const char* format, ...) __attribute__((format(printf, 2, 3)));

/// `path`, or what it is a copy of (sft_file.copies).
const char* sft_original_path(const char* copies, const char* path);

/// Whether the main file declares `node`, and not one that it includes.
bool sft_is_of_main_file(const struct sft_file* file, const void* node);

/// Scoped name of a declared node, "::pkg::msg::X".
const char* sft_scoped_name(const void* node);
