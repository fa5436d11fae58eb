#include "model.h"

#include <stdlib.h>

void sft_file_free(struct sft_file* file) {
  for (size_t i = 0; i < file->declaration_count; ++i) {
    const struct sft_declaration* declaration = &file->declarations[i];
    for (size_t m = 0; m < declaration->member_count; ++m) free(declaration->members[m].initial_elements);
    free(declaration->enumerators);
    free(declaration->members);
  }
  for (size_t i = 0; i < file->text_count; ++i) free(file->texts[i]);
  free(file->texts);
  free(file->declarations);
  free(file->includes);
  free(file->sources);
}
