// Writes the C++ header of an .idl or .msg file.
#pragma once

#include "model.h"

#ifdef __cplusplus
extern "C" {
#endif

struct sft_output {
  const char* header;        ///< path of the header to write; its directory must exist
  const char* dependencies;  ///< path of the make rule to write; "": none
  /// Directories, separated by colons. A file <root>/a/b/C.idl is included as <a/b/C.hpp>. If several roots
  /// contain a file, the innermost root is used.
  const char* roots;
  const char* base_dir;  ///< another root; null: there is no further root
  /// The namespace around all types, such as "my::robot". Includes of generated headers begin with its
  /// folder, <my/robot/...>. "": there is no such namespace.
  const char* outer_namespace;
};

/// Writes the files that `output` names, each of them completely or not at all. Returns false after an error,
/// which is reported on stderr.
bool sft_emit(const struct sft_file* file, const struct sft_output* output);

#ifdef __cplusplus
}
#endif
