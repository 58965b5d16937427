// SPDX-License-Identifier: Apache-2.0
// Drops a file on a window as a file manager does: the sending side of XDND (version 5), and nothing else.
//
//     drop_file WINDOW FILE      WINDOW: an X11 window's number; FILE: absolute
//
// Exits with 0 once the window has accepted it, with 1 if it has not within ten seconds.
#include <X11/Xatom.h>
#include <X11/Xlib.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>

int main(int argc, char** argv)
{
    if (argc != 3) return 2;
    Display* const display = XOpenDisplay(nullptr);
    if (!display) return 2;
    const Window target = std::strtoul(argv[1], nullptr, 0);
    const Window source = XCreateSimpleWindow(display, DefaultRootWindow(display), 0, 0, 1, 1, 0, 0, 0);
    const auto atom = [&](const char* name) { return XInternAtom(display, name, False); };
    const Atom selection = atom("XdndSelection"), list = atom("text/uri-list"), finished = atom("XdndFinished"),
               status = atom("XdndStatus");
    const std::string uris = "file://" + std::string(argv[2]) + "\r\n";
    XSetSelectionOwner(display, selection, source, CurrentTime);

    const auto send = [&](const char* what, long a, long b, long c, long d) {
        XEvent event{};
        event.xclient.type = ClientMessage;
        event.xclient.display = display;
        event.xclient.window = target;
        event.xclient.message_type = atom(what);
        event.xclient.format = 32;
        const long words[] = {static_cast<long>(source), a, b, c, d};
        for (int i = 0; i < 5; ++i) event.xclient.data.l[i] = words[i];
        XSendEvent(display, target, False, NoEventMask, &event);
        XFlush(display);
    };
    constexpr long k_version = 5;
    send("XdndEnter", k_version << 24, static_cast<long>(list), 0, 0);
    send("XdndPosition", 0, 100 << 16 | 100, CurrentTime, static_cast<long>(atom("XdndActionCopy")));

    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    while (std::chrono::steady_clock::now() < end) {
        if (XPending(display) == 0) {
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
            continue;
        }
        XEvent event;
        XNextEvent(display, &event);
        if (event.type == ClientMessage && event.xclient.message_type == status) {
            const bool taken = event.xclient.data.l[1] & 1;
            if (!taken) return 1;
            send("XdndDrop", 0, CurrentTime, 0, 0);
        } else if (event.type == ClientMessage && event.xclient.message_type == finished) {
            return 0;   // GLFW puts a length where the protocol has a bit
        } else if (event.type == SelectionRequest) {
            const XSelectionRequestEvent& request = event.xselectionrequest;
            XChangeProperty(display, request.requestor, request.property, request.target, 8, PropModeReplace,
                            reinterpret_cast<const unsigned char*>(uris.data()), static_cast<int>(uris.size()));
            XEvent answer{};
            answer.xselection.type = SelectionNotify;
            answer.xselection.requestor = request.requestor;
            answer.xselection.selection = request.selection;
            answer.xselection.target = request.target;
            answer.xselection.property = request.property;
            answer.xselection.time = request.time;
            XSendEvent(display, request.requestor, False, NoEventMask, &answer);
            XFlush(display);
        }
    }
    return 1;
}
