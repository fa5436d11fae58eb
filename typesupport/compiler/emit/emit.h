// Writes the C++ header of an .idl or .msg file.
#pragma once

#include "model.h"

#ifdef __cplusplus
extern "C" {
#endif

struct sft_output {
  const char* header;        ///< path of the header to write; its directory exists
  const char* dependencies;  ///< path of the make rule to write; "": none
  const char* roots;  ///< colon-separated directories: <root>/a/b/C.idl is included as <a/b/C.hpp>, and the
                      ///< innermost root counts
  const char* base_dir;         ///< another root; may be null
  const char* outer_namespace;  ///< the namespace around all types, "my::robot", whose folder,
                                ///< <my/robot/...>, all includes of generated headers begin with; "": none
};

/// Writes the files that `output` names, each of them complete or not at all. Reports errors on stderr and
/// returns false after one.
bool sft_emit(const struct sft_file* file, const struct sft_output* output);

#ifdef __cplusplus
}
#endif
