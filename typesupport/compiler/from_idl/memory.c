#include "memory.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void* sft_resized(void* memory, size_t bytes) {
  void* resized = realloc(memory, bytes);
  if (resized == NULL) {
    fputs("out of memory\n", stderr);
    exit(EXIT_FAILURE);
  }
  return resized;
}

void* sft_grown(void* items, size_t count, size_t item_bytes) {
  void* grown = sft_resized(items, (count + 1) * item_bytes);
  memset((char*)grown + count * item_bytes, 0, item_bytes);
  return grown;
}

const char* sft_keep_text(struct sft_file* file, const char* text) {
  const size_t size = strlen(text) + 1;
  char* copy = sft_resized(NULL, size);
  memcpy(copy, text, size);
  file->texts = sft_grown(file->texts, file->text_count, sizeof *file->texts);
  return file->texts[file->text_count++] = copy;
}
