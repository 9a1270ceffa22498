/* SPDX-License-Identifier: MIT */
/*
 * console.c - arguments, consoles, interruption, other programs
 *
 * A console takes UTF-8 and the control sequences of terminals once it is told to.
 */
#include "os/console.h"

#include <errno.h>
#include <fcntl.h>
#include <io.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <windows.h>

#include <shellapi.h>

#include "os/files.h"
#include "os/windows/wide.h"

enum { BUFFER = 1 << 14, INTERRUPTED = 130 };

static bool output_is_terminal, error_is_terminal;
static UINT old_code_page;

/* ------------------------------------------------------------------------ start */

static void restore_console(void)
{
    if (old_code_page != 0)
        SetConsoleOutputCP(old_code_page);
}

/* False: it is none, or one of an old Windows, which knows no control sequences. */
static bool prepare(DWORD which)
{
    const DWORD wanted = ENABLE_PROCESSED_OUTPUT | ENABLE_VIRTUAL_TERMINAL_PROCESSING;
    const HANDLE handle = GetStdHandle(which);
    DWORD mode;
    return GetConsoleMode(handle, &mode) && SetConsoleMode(handle, mode | wanted);
}

static char *argument_of(const wchar_t *wide)
{
    char *argument = os__narrow(wide);
    if (argument == NULL)
        abort();
    os_take_path(argument);
    return argument;
}

/* Of the arguments of main, letters that the code page lacks are lost. */
static void take_arguments(int *argc, char ***argv)
{
    int count = 0;
    wchar_t **wide = CommandLineToArgvW(GetCommandLineW(), &count);
    char **arguments = calloc((size_t) count + 1, sizeof *arguments);
    if (wide == NULL || arguments == NULL)
        abort();
    for (int i = 0; i < count; i++)
        arguments[i] = argument_of(wide[i]);
    LocalFree(wide);
    *argc = count;
    *argv = arguments;
}

/* Messages are flushed where they end: a console must not get half a letter. */
void os_start(int *argc, char ***argv)
{
    _setmode(_fileno(stdin), _O_BINARY);
    _setmode(_fileno(stdout), _O_BINARY);
    _setmode(_fileno(stderr), _O_BINARY);
    setvbuf(stdout, NULL, _IOFBF, BUFFER);
    setvbuf(stderr, NULL, _IOFBF, BUFFER);
    output_is_terminal = prepare(STD_OUTPUT_HANDLE);
    error_is_terminal = prepare(STD_ERROR_HANDLE);
    const UINT page = GetConsoleOutputCP();
    if (page != 0 && page != CP_UTF8 && SetConsoleOutputCP(CP_UTF8)) {
        old_code_page = page;
        atexit(restore_console);
    }
    take_arguments(argc, argv);
}

bool os_input_is_terminal(void)
{
    DWORD mode;
    return GetConsoleMode(GetStdHandle(STD_INPUT_HANDLE), &mode);
}

bool os_output_is_terminal(void)
{
    return output_is_terminal;
}

bool os_error_is_terminal(void)
{
    return error_is_terminal;
}

int os_columns(void)
{
    CONSOLE_SCREEN_BUFFER_INFO info;
    enum { USUAL = 80 };
    if (!GetConsoleScreenBufferInfo(GetStdHandle(STD_ERROR_HANDLE), &info))
        return USUAL;
    const int columns = info.srWindow.Right - info.srWindow.Left + 1;
    return columns > 0 ? columns : USUAL;
}

/* ------------------------------------------------------------------------ ends */

void os_keep_write_errors(void)
{
    /* they are errors here, no signals */
}

/* The runtime says EINVAL for what it does not know; a pipe that blocks fails in no other way. */
bool os_reader_is_gone(void)
{
    return errno == EPIPE ||
           (errno == EINVAL && GetFileType(GetStdHandle(STD_OUTPUT_HANDLE)) == FILE_TYPE_PIPE);
}

static void (*on_interruption)(int number);
static atomic_bool was_interrupted;

/* Runs in a thread of its own.  After closing, the program ends when this returns. */
static BOOL WINAPI on_control(DWORD what)
{
    const bool closing = what != CTRL_C_EVENT && what != CTRL_BREAK_EVENT;
    if (atomic_exchange(&was_interrupted, true)) {
        restore_console();
        TerminateProcess(GetCurrentProcess(), INTERRUPTED);
    }
    on_interruption(SIGINT);
    if (closing)
        Sleep(INFINITE); /* Windows ends it in a few seconds, if it does not end by itself */
    return TRUE;
}

void os_on_interruption(void (*call)(int number))
{
    on_interruption = call;
    SetConsoleCtrlHandler(on_control, TRUE);
}

/* ------------------------------------------------------------------------ other programs */

char *os_own_path(void)
{
    enum { MOST = 1 << 15 };
    wchar_t *wide = malloc(MOST * sizeof *wide);
    const DWORD length = wide != NULL ? GetModuleFileNameW(NULL, wide, MOST) : 0;
    char *path = length > 0 && length < MOST ? os__narrow(wide) : NULL;
    free(wide);
    if (path != NULL)
        os_take_path(path);
    return path;
}

/* An argument in quotes; backslashes count double before a quote only.  Returns the end. */
static wchar_t *put_quoted(wchar_t *to, const wchar_t *argument)
{
    size_t slashes = 0;
    *to++ = L'"';
    for (const wchar_t *c = argument;; c++) {
        if (*c == L'\\') {
            slashes++;
            continue;
        }
        for (size_t n = *c == L'"' || *c == 0 ? 2 * slashes : slashes; n > 0; n--)
            *to++ = L'\\';
        slashes = 0;
        if (*c == 0)
            break;
        if (*c == L'"')
            *to++ = L'\\';
        *to++ = *c;
    }
    *to++ = L'"';
    *to++ = L' ';
    return to;
}

static wchar_t *command_line(char **argv)
{
    size_t size = 1;
    for (char **a = argv; *a != NULL; a++)
        size += 2 * strlen(*a) + 3;
    wchar_t *line = malloc(size * sizeof *line), *to = line;
    for (char **a = argv; line != NULL && *a != NULL; a++) {
        wchar_t *wide = os__wide(*a);
        if (wide == NULL) {
            free(line);
            return NULL;
        }
        to = put_quoted(to, wide);
        free(wide);
    }
    if (line != NULL)
        *to = 0;
    return line;
}

/* Windows has no exec: this program waits, and ends with the other's code. */
bool os_become(char **argv)
{
    STARTUPINFOW startup = { .cb = sizeof startup };
    PROCESS_INFORMATION process;
    char *name = malloc(strlen(argv[0]) + sizeof ".exe");
    wchar_t *program = name != NULL ? os__wide_path(strcat(strcpy(name, argv[0]), ".exe")) : NULL;
    wchar_t *line = command_line(argv);
    free(name);
    const bool started =
        program != NULL && line != NULL &&
        CreateProcessW(program, line, NULL, NULL, TRUE, 0, NULL, NULL, &startup, &process);
    if (!started)
        os__failed();
    free(program);
    free(line);
    if (!started)
        return false;
    DWORD code = 1;
    SetConsoleCtrlHandler(NULL, TRUE); /* Ctrl-C is for the other */
    WaitForSingleObject(process.hProcess, INFINITE);
    GetExitCodeProcess(process.hProcess, &code);
    exit((int) code);
}
