#include "model.h"

#include <stdlib.h>

void sft_file_free(struct sft_file* file) {
  for (size_t i = 0; i < file->declaration_count; ++i) {
    free(file->declarations[i].enumerators);
    free(file->declarations[i].members);
  }
  free(file->declarations);
  free(file->includes);
  free(file->sources);
}
