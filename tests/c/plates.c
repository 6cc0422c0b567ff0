/* Two unit squares face each other at distance 1. The form factor is printed, written and read back; bad input is
   refused. */
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <viewpeel/c.h>

static int check(viewpeel_status status) {
  if (status != VIEWPEEL_OK) fprintf(stderr, "%s\n", viewpeel_last_error());
  return status != VIEWPEEL_OK;
}

/* Writes one of the squares, facing the other one. */
static int write_part(const char* file, int height) {
  FILE* out = fopen(file, "w");
  if (!out) return 1;
  fprintf(out, "v 0 0 %d\nv 1 0 %d\nv 1 1 %d\nv 0 1 %d\n%s\n", height, height, height, height,
          height ? "f 4 3 2 1" : "f 1 2 3 4");
  return fclose(out);
}

int main(int argc, char** argv) {
  const double points[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1};
  const uint32_t corners[] = {0, 1, 2, 3, 4, 7, 6, 5}, wrong[] = {0, 1, 2, 3, 4, 7, 6, 8};
  const size_t starts[] = {0, 4, 8};
  const char* names[] = {"floor", "ceiling"};
  viewpeel_scene *scene = NULL, *of_parts = NULL;
  viewpeel_result *result = NULL, *read = NULL, *estimated = NULL, *by_mean = NULL, *joined = NULL;
  const viewpeel_options options = {.tolerance = 1e-3}, estimate = {.tolerance = 1e-3, .promise = -1};
  double f = 0, error = 0, outside = 0, again = 0, of_mean = 0, of_joined = 0;
  if (argc != 2) return 2;

  if (viewpeel_build_scene(points, 8, wrong, starts, 2, names, &scene) != VIEWPEEL_BAD_INPUT || scene) return 1;
  if (!strstr(viewpeel_last_error(), "polygon 1: corner 8")) return 1;
  if (check(viewpeel_build_scene(points, 8, corners, starts, 2, names, &scene))) return 1;
  if (check(viewpeel_compute(scene, &options, &result))) return 1;
  if (check(viewpeel_compute(scene, &estimate, &estimated))) return 1;
  const viewpeel_options mean = {.rms = 1e-5}, both = {.rms = 1e-5, .tolerance = 1e-3};
  if (check(viewpeel_compute(scene, &mean, &by_mean))) return 1;
  if (viewpeel_compute(scene, &both, &read) != VIEWPEEL_BAD_USAGE || read) return 1;
  if (!strstr(viewpeel_last_error(), "rms beside another goal")) return 1;
  viewpeel_free_scene(scene);
  if (write_part("c_floor.obj", 0) || write_part("c_ceiling.obj", 1)) return 1;
  const char* const parts[] = {"c_floor.obj", "c_ceiling.obj"};
  if (viewpeel_load_scene_files(parts, 0, &of_parts) != VIEWPEEL_BAD_USAGE || of_parts) return 1;
  if (check(viewpeel_load_scene_files(parts, 2, &of_parts))) return 1;
  if (check(viewpeel_compute(of_parts, &options, &joined))) return 1;
  viewpeel_free_scene(of_parts);
  if (check(viewpeel_form_factor(joined, 0, 1, &of_joined, NULL))) return 1;
  if (strcmp(viewpeel_row_name(joined, 1), "c_ceiling")) return 1;
  if (check(viewpeel_form_factor(by_mean, 0, 1, &of_mean, NULL))) return 1;
  if (check(viewpeel_form_factor(result, 0, 1, &f, &error))) return 1;
  if (check(viewpeel_form_factor(result, 0, VIEWPEEL_ENVIRONMENT, &outside, NULL))) return 1;
  printf("%s to %s %.6f +- %.1e\n", viewpeel_row_name(result, 0), viewpeel_row_name(result, 1), f, error);
  if (check(viewpeel_write_result(result, argv[1])) || check(viewpeel_read_result(argv[1], &read))) return 1;
  if (check(viewpeel_form_factor(read, 1, 0, &again, NULL))) return 1;
  const viewpeel_rows rows = viewpeel_get_rows(read);
  const int is_right = fabs(f - 0.1998248957) < 1e-7 && fabs(f + outside - 1) < 1e-6 && fabs(again - f) < 1e-15 &&
                       fabs(of_mean - f) < 1e-7 && fabs(of_joined - f) < 1e-7 &&
                       rows.row_count == 2 && rows.entry_count == 2 && rows.columns[0] == 1 && rows.lower && rows.lower[0] <= f && f <= rows.upper[0] &&
                       rows.upper[0] - rows.lower[0] <= 2e-3 && !viewpeel_get_rows(estimated).lower;
  viewpeel_free_result(result), viewpeel_free_result(read), viewpeel_free_result(estimated);
  viewpeel_free_result(by_mean), viewpeel_free_result(joined);
  return !is_right;
}
