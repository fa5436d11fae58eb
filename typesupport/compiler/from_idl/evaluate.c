#include "evaluate.h"

#include <ctype.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "memory.h"
#include "read_type.h"

static char* content_of(const char* path) {
  FILE* file = fopen(path, "rb");
  if (file == NULL) return NULL;
  char* content = NULL;
  size_t length = 0;
  for (size_t capacity = 4096;; capacity *= 2) {
    content = sft_resized(content, capacity);
    length += fread(content + length, 1, capacity - 1 - length, file);
    if (length < capacity - 1) break;
  }
  fclose(file);
  content[length] = '\0';
  return content;
}

static const char* character_at(const char* content, const idl_position_t* place) {
  for (uint32_t line = 1; line < place->line; ++line) {
    content = strchr(content, '\n');
    if (content == NULL) return NULL;
    ++content;
  }
  return strcspn(content, "\n") >= place->column ? content + place->column - 1 : NULL;
}

static const char* skip_spaces_back(const char* content, const char* at) {
  while (at > content && isspace((unsigned char)at[-1])) --at;
  return at;
}

static bool ends_with(const char* content, const char* end, const char* word) {
  const size_t length = strlen(word);
  return (size_t)(end - content) >= length && strncmp(end - length, word, length) == 0;
}

// Returns the position after the last "@default(" or "@default(value=" that begins before `at`.
static const char* start_of_argument(const char* content, const char* at) {
  for (; at > content; --at) {
    if (at[-1] != '(') continue;
    const char* word_end = skip_spaces_back(content, at - 1);
    if (!ends_with(content, word_end, "@default")) continue;
    at += strspn(at, " \t\r\n");
    if (strncmp(at, "value", 5) != 0) return at;
    at += 5;
    at += strspn(at, " \t\r\n");
    return *at == '=' ? at + 1 : NULL;
  }
  return NULL;
}

static size_t length_of_argument(const char* start) {
  char quote = '\0';
  int depth = 0;
  const char* end = start;
  for (; *end != '\0'; ++end) {
    if (quote != '\0') {
      if (*end == '\\' && end[1] != '\0')
        ++end;
      else if (*end == quote)
        quote = '\0';
    } else if (*end == '"' || *end == '\'') {
      quote = *end;
    } else if (*end == '(') {
      ++depth;
    } else if (*end == ')' && depth-- == 0) {
      break;
    }
  }
  return (size_t)(end - start);
}

// Macros make idlc's columns wrong. The text counts only if it contains the position that idlc gives.
char* sft_source_text(const struct sft_reading* reading, const void* expression) {
  const idl_position_t* place = &idl_location(expression)->first;
  char* content = content_of(sft_original_path(reading->file->copies, place->source->path->name));
  if (content == NULL) return NULL;
  const char* at = character_at(content, place);
  const char* start = at == NULL ? NULL : start_of_argument(content, at);
  char* text = NULL;
  if (start != NULL) {
    const size_t length = length_of_argument(start);
    if (at < start + length) text = strndup(start, length);
  }
  free(content);
  return text;
}

static const char* spelling_of(enum sft_kind kind) {
  static const char* const names[] = {"boolean", "octet",  "char",  "int8",   "uint8", "int16",  "uint16",
                                      "int32",   "uint32", "int64", "uint64", "float", "double", "string"};
  return names[kind];
}

// The "#" line makes idlc's messages name the place of the expression.
static char* constant_declaration(enum sft_kind kind, const char* text, const void* expression) {
  const idl_position_t* place = &idl_location(expression)->first;
  const char* format = "const %s value =\n# %" PRIu32 " \"%s\"\n%*s%s;\n";
  const int indent = (int)place->column - 1;
  const size_t size = strlen(format) + strlen(place->file->name) + (size_t)indent + strlen(text) + 32;
  char* declaration = sft_resized(NULL, size);
  snprintf(declaration, size, format, spelling_of(kind), place->line, place->file->name, indent, "", text);
  return declaration;
}

struct sft_value sft_evaluate(struct sft_reading* reading, enum sft_kind kind, const char* text,
                              const void* expression) {
  struct sft_value result = {.is_set = false};
  idl_pstate_t* state = NULL;
  if (idl_create_pstate(IDL_FLAG_EXTENDED_DATA_TYPES, NULL, &state) != IDL_RETCODE_OK) return result;
  char* declaration = constant_declaration(kind, text, expression);
  if (idl_parse_string(state, declaration) == IDL_RETCODE_OK && idl_is_const(state->root) &&
      idl_next(state->root) == NULL) {
    const struct sft_type type = {.kind = kind};
    result = sft_read_value(&type, ((const idl_const_t*)state->root)->const_expr);
    if (kind == SFT_STRING) result.text = sft_keep_text(reading->file, result.text);
  }
  free(declaration);
  idl_delete_pstate(state);
  return result;
}
