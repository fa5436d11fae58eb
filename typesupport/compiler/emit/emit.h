// Writes the C++ header of an .idl or .msg file.
#pragma once

#include "model.h"

#ifdef __cplusplus
extern "C" {
#endif

struct sft_output {
  const char* header;        ///< path of the header to write; its directory exists
  const char* dependencies;  ///< path of the make rule to write; "": none
  const char* roots;         ///< colon-separated directories: <root>/a/b/C.idl is included as <a/b/C.hpp>; of
                             ///< several roots that contain a file, the innermost is used
  const char* base_dir;      ///< another root, or null
  const char* outer_namespace;  ///< the namespace around all types, "my::robot"; includes of generated
                                ///< headers begin with its folder, <my/robot/...>; "": none
};

/// Writes the files that `output` names, each of them completely or not at all. Returns false after an error,
/// which is reported on stderr.
bool sft_emit(const struct sft_file* file, const struct sft_output* output);

#ifdef __cplusplus
}
#endif
