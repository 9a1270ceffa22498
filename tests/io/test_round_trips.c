/* SPDX-License-Identifier: MIT */
/*
 * test_round_trips.c - what is written is read back the same, texts and all
 */
#include "written.h"

static void round_trips(void)
{
    for (int format = NTPIO_PNG; format <= NTPIO_PFM; format++) {
        for (int32_t c = 1; c <= 4; c++) {
            for (int32_t b = 1; b <= 4; b *= 2) {
                for (int32_t level = -1; level <= 12; level += level < 0 ? 2 : 1) {
                    ntpio_write_options o = rgb(23);
                    o.format = (ntpio_format) format;
                    o.channels = c;
                    o.sample_bytes = b;
                    o.level = level;
                    const bool fits = format == NTPIO_PNG   ? b <= 2
                                      : format == NTPIO_TGA ? b == 1 && c != 2
                                      : format == NTPIO_PFM ? b == 4 && (c == 1 || c == 3)
                                                            : false;
                    CHECK(write_all("trip", &o) == fits);
                    if (fits)
                        ntpio_close(read_back("trip", &o));
                    else
                        CHECK(error.status == NTPIO_ERR_USAGE);
                    unlink("trip");
                }
            }
        }
    }
    CHECK(entries() == 0);
}

static void metadata(void)
{
    static char title[] = "Title", plain[] = "plain", comment[] = "Comment", author[] = "Author",
                packed[] = "packed packed packed", name[] = "J\xc3\xb6rg", de[] = "de",
                autor[] = "Autor";
    ntpio_text texts[] = {
        { .key = title, .value = plain },
        { .key = comment, .value = packed, .compressed = true },
        { .key = author, .value = name, .language = de, .translated_key = autor, .itxt = true },
    };
    ntpio_info info = { .has_phys = true, .phys_x = 11, .phys_y = 12, .phys_unit = 1 };
    ntpio_write_options o = rgb(5);
    o.copy_from = &info;
    info.texts = texts;
    info.text_count = 2;
    ntpio_writer *w = ntpio_create("meta.png", &o, &error);
    CHECK(w != NULL && ntpio_write_rows(w, noise, 15, 5, &error));
    info.text_count = 3; /* one that came after the pixels */
    CHECK(ntpio_commit(w, &error));
    ntpio_reader *r = read_back("meta.png", &o);
    const ntpio_info *got = ntpio_reader_info(r);
    ntpio_close_file(r); /* the info stays */
    CHECK(remove("meta.png") == 0 && write_all("meta.png", &o));
    CHECK(got->has_phys && got->phys_x == 11 && got->phys_y == 12 && got->text_count == 3);
    for (size_t i = 0; i < 3; i++) {
        CHECK(strcmp(got->texts[i].key, texts[i].key) == 0);
        CHECK(strcmp(got->texts[i].value, texts[i].value) == 0);
        CHECK(got->texts[i].compressed == texts[i].compressed &&
              got->texts[i].itxt == texts[i].itxt);
    }
    CHECK(strcmp(got->texts[2].translated_key, "Autor") == 0);
    ntpio_close(r);
    unlink("meta.png");
}

int main(void)
{
    CHECK(system_enter_folder());
    make_noise();
    round_trips();
    metadata();
    CHECK(system_leave_folder());
    return 0;
}
