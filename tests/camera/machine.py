"""A machine in QEMU with Debian's kernel and emulated USB cameras; and the frames they play."""
import os
import socket
import subprocess


class Player:
    """Plays YUYV frames as a USB camera, for a machine that is to connect. The frames "-" are
    the orders of a pipe."""

    # pylint: disable=too-many-arguments
    def __init__(self, program, folder, name, size, rate, frames, unplug_after=0, orders=None):
        self.output = ""  # after end()
        self.socket = os.path.join(folder, name + ".socket")
        # pylint: disable=consider-using-with
        self.process = subprocess.Popen(
            [program, self.socket, "{}x{}".format(*size), str(rate), frames, str(unplug_after)],
            stdin=orders, stdout=subprocess.PIPE, text=True)
        self.process.stdout.readline()  # ready

    def kill(self):
        self.process.kill()
        self.process.communicate()

    def end(self):
        """Waits until the machine has gone, and returns how many frames were sent."""
        self.output, _ = self.process.communicate(timeout=20)
        return int(self.output.split()[0])


def build_image(fetched_kernel, image, programs):
    here = os.path.join(os.path.dirname(os.path.abspath(__file__)), "vm")
    subprocess.run([os.path.join(here, "make_image"), fetched_kernel, image, *programs], check=True)


def free_port():
    with socket.create_server(("127.0.0.1", 0)) as server:
        return server.getsockname()[1]


# pylint: disable=too-many-arguments
def boot(kernel, image, shared, players, job, timeout, cpu="max", forward=None):
    """Runs a shell script in the machine, and returns its status and what it printed. The folder
    shared is /shared there; camera i of the players is at USB port i + 1. forward is a port of
    127.0.0.1 and the machine's own that is reached there, at 10.0.2.15."""
    with open(os.path.join(shared, "job"), "w", encoding="utf-8") as file:
        file.write(job)
    boot_folder = os.path.join(kernel, "boot")
    linux = next(name for name in os.listdir(boot_folder) if name.startswith("vmlinuz"))
    command = ["qemu-system-x86_64", "-machine", "q35,accel=tcg", "-cpu", cpu, "-smp", "2",
               "-m", "1024", "-nographic", "-no-reboot",
               "-kernel", os.path.join(boot_folder, linux), "-initrd", image,
               "-append", "console=ttyS0 quiet loglevel=4 panic=-1",
               "-fsdev", f"local,id=shared,path={shared},security_model=none",
               "-device", "virtio-9p-pci,fsdev=shared,mount_tag=shared",
               "-device", "qemu-xhci,p2=8,p3=8"]
    if forward:
        forward = "hostfwd=tcp:127.0.0.1:{}-:{}".format(*forward)
    command += ["-nic", f"user,restrict=on,model=virtio-net-pci,{forward}" if forward else "none"]
    for i, player in enumerate(players):
        command += ["-chardev", f"socket,id=camera{i},path={player.socket}",
                    "-device", f"usb-redir,chardev=camera{i},port={i + 1}"]
    result = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, timeout=timeout,
                            check=False)
    log = read_text(os.path.join(shared, "log"))
    status = read_text(os.path.join(shared, "status"))
    if not status:  # it did not come to the end
        log += result.stdout.decode(errors="replace") + result.stderr.decode(errors="replace")
    return int(status or -1), log


def read_text(path):
    if not os.path.exists(path):
        return ""
    with open(path, encoding="utf-8", errors="replace") as file:
        return file.read()


def make_frames(grey_frames, width, height, count):
    """YUYV frames with the luma of the grey ones in turn, chroma that differs everywhere, and a
    number in squares in the middle, so that no two are the same."""
    cell = 16
    ramp = bytes(i & 255 for i in range(256 + width // 2))
    steep = [bytes((3 * x - y) & 255 for x in range(width // 2)) for y in range(256)]
    frames = []
    for k in range(count):
        grey = bytearray(grey_frames[k % len(grey_frames)])
        for bit in range(8):
            value = 235 if k >> bit & 1 else 16
            left = width // 2 + (bit - 4) * cell
            for y in range(height // 2, height // 2 + cell):
                grey[y * width + left:y * width + left + cell] = bytes([value]) * cell
        frame = bytearray(2 * width * height)
        frame[0::2] = grey
        for y in range(height):
            row = 2 * width * y
            start = (y + k) & 255
            frame[row + 1:row + 2 * width:4] = ramp[start:start + width // 2]
            frame[row + 3:row + 2 * width:4] = steep[y & 255]
        frames.append(bytes(frame))
    return frames
