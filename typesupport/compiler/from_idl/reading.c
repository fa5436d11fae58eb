#include "reading.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

void sft_refuse(struct sft_reading* reading, const char* format, ...) {
  const idl_position_t* place = &idl_location(reading->node)->first;
  fprintf(stderr, "%s:%" PRIu32 ":", place->source->file->name, place->line);
  if (reading->column != 0) fprintf(stderr, "%" PRIu32 ":", reading->column);
  fprintf(stderr, " %s%s%s: ", reading->owner + strlen("::"), reading->member ? "." : "",
          reading->member ? reading->member : "");
  va_list arguments;
  va_start(arguments, format);
  vfprintf(stderr, format, arguments);
  va_end(arguments);
  fputc('\n', stderr);
  reading->is_refused = true;
}

const char* sft_original_path(const char* copies, const char* path) {
  const size_t length = strlen(copies);
  return strncmp(path, copies, length) == 0 ? path + length : path;
}

bool sft_is_of_main_file(const struct sft_file* file, const void* node) {
  const char* path = idl_location(node)->first.source->path->name;
  return strcmp(sft_original_path(file->copies, path), file->path) == 0;
}

const char* sft_scoped_name(const void* node) { return idl_declaration(node)->scoped_name->identifier; }
