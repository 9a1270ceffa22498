/* SPDX-License-Identifier: MIT */
/*
 * press_ctrl_c.c - press_ctrl_c FILE MILLISECONDS TIMES COMMAND...: starts a command, waits until
 * there is a file and so much longer, presses Ctrl-C in the console so often, and ends with the exit
 * code of the command
 */
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <windows.h>

enum { NOT_STARTED = 90, NOT_PRESSED = 91, STILL_RUNNING = 92, PATIENCE = 60000, PAUSE = 20 };

/* A file that will vanish when it is closed cannot be looked at, but is there. */
static bool is_there(const char *path)
{
    return GetFileAttributesA(path) != INVALID_FILE_ATTRIBUTES ||
           GetLastError() == ERROR_ACCESS_DENIED;
}

int main(int argc, char **argv)
{
    static char line[1 << 15];
    STARTUPINFOA startup = { .cb = sizeof startup };
    PROCESS_INFORMATION process;
    DWORD code = 0;
    for (int i = 4; i < argc; i++)
        sprintf(line + strlen(line), "\"%s\" ", argv[i]);
    if (argc < 5 ||
        !CreateProcessA(NULL, line, NULL, NULL, TRUE, 0, NULL, NULL, &startup, &process))
        return NOT_STARTED;
    SetConsoleCtrlHandler(NULL, TRUE); /* it is not for this program */
    for (int waited = 0; waited < PATIENCE && !is_there(argv[1]); waited += PAUSE)
        Sleep(PAUSE);
    Sleep((DWORD) atoi(argv[2]));
    for (int n = atoi(argv[3]); n > 0; n--) {
        if (!GenerateConsoleCtrlEvent(CTRL_C_EVENT, 0))
            return NOT_PRESSED;
        Sleep(PAUSE);
    }
    if (WaitForSingleObject(process.hProcess, PATIENCE) != WAIT_OBJECT_0)
        return STILL_RUNNING;
    GetExitCodeProcess(process.hProcess, &code);
    return (int) code;
}
