/* SPDX-License-Identifier: MIT */
/*
 * examine.h - finding out what a file is
 *
 * The room that reads images and measures them.
 *   worker.c            the memory of a thread, used again from file to file
 *   read_blocks.c       a file as blocks of rows in a ring; a second thread may read ahead
 *   hold_image.c        a file held whole
 *   samples.c           sizes of samples; channels in another order (reorder_tmpl.h)
 *   examine.c           the facts of a file: its class, statistics, encoding
 *   orient.c            which way green points, and whether it matters, while rows go by
 *   middle_and_lines.c  what a check keeps of the rows: the middle, and some lines
 */
#ifndef NTP_CLI_EXAMINE_H
#define NTP_CLI_EXAMINE_H

#include "examine/read_blocks.h"
#include "options/options.h"

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
    double residual;   /* rms of what the best heights leave, in levels; negative: not known */
    ntp_rect fit_area; /* that the residual is of */
    ntp_steps steps;   /* of slopes */
} surface_facts;

/* What exchange.c adds: by how much x and y fit a surface better when exchanged (a share of the energy
 * of the derivatives), and in standard deviations. */
typedef struct exchange_facts {
    double difference, deviations;
    bool sure;
} exchange_facts;

/* What mips.c adds: are mips plain means of x and y, and how far is that from the right ones? */
typedef struct mips_facts {
    bool plain;
    double degrees;
} mips_facts;

/* Texels that are wrong beyond rounding: in length (red and green alone included), in red and green
 * alone, by negative z. */
typedef enum harm_kind { HARM_LENGTH, HARM_XY, HARM_Z, HARM_KINDS } harm_kind;

/* What is known of a file after it was read. */
typedef struct facts {
    const input *in;
    ntpio_info info; /* without the texts */
    ntp_stats stats;
    ntp_harm harm[HARM_KINDS]; /* over: by more than the source's max_angle */
    ntp_classification type;
    ntp_encoding encoding;              /* that the texels were read as */
    ntp_orientation_result orientation; /* undecided when it was not asked for */
    steepest most;                      /* only if it was asked for */
    surface_facts surface;
    exchange_facts exchange;
    mips_facts mips;
    bool forced;         /* by --type */
    bool counts;         /* it is judged: named, or a normals texture by its name or content */
    level_count *levels; /* the histogram of levels_off, without zeros */
    size_t level_count;
} facts;

void facts_free(facts *f);

/* The encoding in which texels of a class are read. */
ntp_encoding class_encoding(ntp_class type, int32_t channels);
/* Standard, Z-zero, XY or object-space. */
bool class_is_normals(ntp_class type);
/* Standard, Z-zero or XY: normals in tangent space. */
bool class_is_tangent(ntp_class type);
/* The same of a file, and x and y are in the right channels. */
bool facts_are_tangent(const facts *f);
/* "Z-zero" where ntp_class_name says "zzero": for people. */
const char *class_title(ntp_class type);

/* The kinds of unused texels that are normals after all: alpha 0 where alpha is a height. */
uint32_t touch_for(const ntp_stats *stats, ntp_encoding encoding);

/* Works out the facts from the worker's tally, measured as the view says. */
bool facts_from_tally(facts *f, source *s, int forced, ntpio_error *error);

/*
 * Reads the whole file, a second time if its class needs it, and fills *f.  The view is then that
 * of the class.
 */
bool examine(source *s, int forced, facts *f, ntpio_error *error);

/* The same with the view that is set, not the first view of the class. */
bool examine_as_seen(source *s, int forced, facts *f, ntpio_error *error);

/* The orientation: before the first row, for each block of rows, and when the class is known. */
void orient_begin(source *s);
ntp_status orient_rows(source *s, const ntp_rect *area, uint32_t touch);
void orient_end(const source *s, facts *f);

/* Adds the used texels of a row. */
void slopes_add(steepest *most, const ntp_const_image *view, const void *row, uint32_t touch);
/* Is a member of `most` 0 as nearly as the depth can say: the two levels in the middle? */
bool slopes_are_flat(int32_t most, const ntp_stats *stats);

/* Sets the first view of a file: of the forced class, else standard, and heights for gray files. */
void first_view(source *s, int forced);

#endif
