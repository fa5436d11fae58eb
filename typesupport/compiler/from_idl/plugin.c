// The options and the entry point of the generator, which idlc loads (idlc -l libcycloneddsidlsft.so).
#include <stdlib.h>

#include "emit/emit.h"
#include "idl/file.h"
#include "idlc/generator.h"
#include "reader.h"
#include "reading.h"

#define EXPORTED __attribute__((visibility("default")))

// idlc asks for pointers to these variables before it calls generate(), and stores the arguments of options
// in them. So they are static.
static const char* include_roots = "";
static const char* dependency_file = "";
static const char* copies = "";
static const char* outer_namespace = "";

EXPORTED const idlc_option_t** generator_options(void);
EXPORTED idl_retcode_t generate(const idl_pstate_t* state, const idlc_generator_config_t* config);

const idlc_option_t** generator_options(void) {
  static const idlc_option_t roots = {
      .type = IDLC_STRING,
      .store = {.string = &include_roots},
      .option = 'r',
      .suboption = "",
      .argument = "<directories>",
      .help =
          "Colon-separated directories below which the headers of included files mirror the IDL files. "
          "(default: <base_dir>, or else the directory of the file).",
  };
  static const idlc_option_t dependencies = {
      .type = IDLC_STRING,
      .store = {.string = &dependency_file},
      .option = 'd',
      .suboption = "",
      .argument = "<file>",
      .help = "Write to <file>, as a make rule, which files the generated header depends on.",
  };
  static const idlc_option_t copied = {
      .type = IDLC_STRING,
      .store = {.string = &copies},
      .option = 'c',
      .suboption = "",
      .argument = "<directory>",
      .help = "All files are copies: the original of <directory>/a/b.idl is /a/b.idl.",
  };
  static const idlc_option_t enclosing = {
      .type = IDLC_STRING,
      .store = {.string = &outer_namespace},
      .option = 'N',
      .suboption = "",
      .argument = "<namespace>",
      .help =
          "Put all into this namespace, as my::robot. Included files are <my/robot/...hpp>, so let the "
          "output "
          "directory end with my/robot.",
  };
  static const idlc_option_t* options[] = {&roots, &dependencies, &copied, &enclosing, NULL};
  return options;
}

static idl_retcode_t emit(const idl_pstate_t* state, const idlc_generator_config_t* config,
                          const struct sft_file* file) {
  const char* base_dir = config->base_dir == NULL ? NULL : sft_original_path(copies, config->base_dir);
  struct sft_output output = {.roots = include_roots,
                              .base_dir = base_dir,
                              .dependencies = dependency_file,
                              .outer_namespace = outer_namespace};
  char* header = NULL;
  const idl_retcode_t result = idl_generate_out_file(state->sources->file->name, config->output_dir,
                                                     config->base_dir, "hpp", &header, 0);
  if (result != IDL_RETCODE_OK) {
    idl_error(state, NULL, "no output path for this file: pass its directory, or one above it, with -b");
    return result;
  }
  output.header = header;
  const bool is_written = sft_emit(file, &output);
  free(header);
  return is_written ? IDL_RETCODE_OK : IDL_RETCODE_NO_ACCESS;
}

idl_retcode_t generate(const idl_pstate_t* state, const idlc_generator_config_t* config) {
  struct sft_file file = {.copies = copies};
  const idl_retcode_t result =
      sft_read_file(state, &file) ? emit(state, config, &file) : IDL_RETCODE_UNSUPPORTED;
  sft_file_free(&file);
  return result;
}
