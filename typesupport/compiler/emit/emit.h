// Writes the C++ header of a file.
#pragma once

#include "model.h"

#ifdef __cplusplus
extern "C" {
#endif

struct sft_output {
  const char* header;        ///< path to write to, in a directory that exists
  const char* dependencies;  ///< path of the make rule to write; "": none
  const char* roots;  ///< colon-separated: an included a/b/C.idl below one of them, the innermost if there
                      ///< are several, is <a/b/C.hpp> in C++
  const char* base_dir;  ///< one more root, may be null
};

/// Writes the files that `output` names, each complete or not at all. False after an error, which is reported
/// on stderr.
bool sft_emit(const struct sft_file* file, const struct sft_output* output);

#ifdef __cplusplus
}
#endif
