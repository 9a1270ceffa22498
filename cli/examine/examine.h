/* SPDX-License-Identifier: MIT */
/*
 * examine.h - reading a file row by row, and finding out what it is
 */
#ifndef NTP_CLI_EXAMINE_H
#define NTP_CLI_EXAMINE_H

#include <libntp.h>
#include <ntpio.h>
#include <stdatomic.h>
#include <stdbool.h>

#include "options/options.h"
#include "files/paths.h"

/* A piece of memory that grows and is used again. */
typedef struct buffer {
    unsigned char *data;
    size_t size;
} buffer;

unsigned char *buffer_reserve(buffer *b, size_t size);

/* What one thread works with, from file to file. */
typedef struct worker {
    ntp_tally *tally;
    buffer rows;  /* the ring of rows that a view looks at */
    buffer raw;   /* rows as the file has them, where their channels are rearranged */
    buffer extra; /* the verb's own */
    buffer extra2;
    buffer diff;         /* an ntp_diff */
    uint64_t *histogram; /* NTP levels 0..65535 */
    ntp_orientation *orientation;
    buffer band; /* rows around the one whose orientation is measured */
    buffer crop; /* what middle_and_lines.c keeps: the middle, rows, columns */
    buffer across;
    buffer down;
    bool may_read_ahead;  /* a processor is idle */
    int threads;          /* that this worker may keep busy, itself included */
    _Atomic int permille; /* of the file at work, for the progress bar */
} worker;

worker *worker_new(void);
void worker_free(worker *w);

/* What a channel of a view is taken from: a channel of the file, or a constant. */
enum { FROM_ZERO = -1, FROM_ONE = -2 };

/* Whether examine() measures which way green points. */
typedef enum orient { ORIENT_NOT, ORIENT_SAMPLED, ORIENT_EVERY_ROW } orient;

/* A file being read. */
typedef struct source {
    const input *in;
    const ntpio_limits *limits;
    worker *w;
    unsigned char *bytes; /* the whole file where it cannot be read twice */
    size_t size;
    ntpio_reader *reader;
    const ntpio_info *info;
    ntp_image view; /* set by source_view */
    bool mapped;
    int8_t map[4];       /* of the view's channels, where mapped */
    int32_t block_rows;  /* rows that source_next delivers at once */
    struct ahead *ahead; /* the thread that reads ahead, or NULL */
    uint32_t next;       /* the next row */
    int read_permille;   /* of the work that reading is; 0: all of it */
    orient orient;
    bool keep_crop; /* for surface.c */
} source;

bool source_open(source *s, worker *w, const input *in, const ntpio_limits *limits,
                 ntpio_error *error);
/* Back to the first row; the view stays. */
bool source_rewind(source *s, ntpio_error *error);
void source_close(source *s);

/* How the rows are to be seen.  map: NULL, or where each of `channels` comes from. */
void source_view(source *s, ntp_encoding encoding, ntp_y y, const int8_t *map, int32_t channels);

/* Reads the next rows into the ring.  1: *area has them; 0: the end was reached and checked;
 * -1: *error tells why not. */
int source_next(source *s, ntp_rect *area, ntpio_error *error);

/* Where the rows of an area that source_next delivered lie. */
unsigned char *source_rows(const source *s, const ntp_rect *area);

/* The limits that the options set. */
ntpio_limits limits_from(const options *o);

/* What --type says: -1 for auto, else an ntp_class. */
int forced_class(const options *o);

typedef struct level_count {
    uint32_t level;
    uint64_t count;
} level_count;

/* What surface.c adds. */
typedef struct surface_facts {
    bool known;
    bool deep;     /* asked for by --deep */
    ntp_rect area; /* that the kernel and the steps are of */
    ntp_kernel_fit origin;
    ntp_seam seam[2];  /* of the whole texture: across, down */
    double residual;   /* of the best heights, in levels; negative: not known */
    ntp_rect fit_area; /* that the residual is of */
    ntp_steps steps;   /* of slopes */
} surface_facts;

/* What is known of a file after it was read. */
typedef struct facts {
    const input *in;
    ntpio_info info; /* without the texts */
    ntp_stats stats;
    ntp_classification type;
    ntp_encoding encoding;              /* that the texels were read as */
    ntp_orientation_result orientation; /* undecided when it was not asked for */
    surface_facts surface;
    bool forced;         /* by --type */
    bool counts;         /* named, or a normals texture by its name or content */
    level_count *levels; /* the histogram of levels_off, without zeros */
    size_t level_count;
} facts;

void facts_free(facts *f);

/* The encoding in which texels of a class are read. */
ntp_encoding class_encoding(ntp_class type, int32_t channels);
/* Standard, Z-zero, XY or object-space. */
bool class_is_normals(ntp_class type);
/* "Z-zero" where ntp_class_name says "zzero": for people. */
const char *class_title(ntp_class type);

/* The unused texels to touch for a file read so: alpha 0 where alpha is a height. */
uint32_t touch_for(const ntp_stats *stats, ntp_encoding encoding);

/* Works out the facts from the worker's tally, measured as the view says. */
bool facts_from_tally(facts *f, source *s, int forced, ntpio_error *error);

/*
 * Reads the whole file, again where the class asks for it, and fills *f.  Leaves the view as
 * the class has it.
 */
bool examine(source *s, int forced, facts *f, ntpio_error *error);

/* The orientation: before the first row, for each block of rows, and when the class is known. */
void orient_begin(source *s);
ntp_status orient_rows(source *s, const ntp_rect *area, uint32_t touch);
void orient_end(const source *s, facts *f);

/* Prepares the first view of a file: as forced, else standard, gray files as heights. */
void first_view(source *s, int forced);

/* A status of libntp that cannot happen with right arguments, as an error about the file. */
bool library_error(const source *s, ntp_status status, ntpio_error *error);

#endif
