"""The module raygrid in MicroPython without floats: integers_test.py formats/vectors."""
import sys
from array import array

import raygrid

FOLDER = sys.argv[1]


def open_camera(name):
    with open(FOLDER + "/" + name + ".raygrid", "rb") as file:
        return raygrid.Camera(file.read())


def test_rays():
    """Of all central cameras, a stack at each of its conditions among them."""
    count, name, camera = 0, None, None
    with open(FOLDER + "/rays.csv") as file:
        file.readline()
        for line in file:
            fields = line.split(",")
            if fields[0] != name:
                name, camera = fields[0], open_camera(fields[0])
            if fields[1]:
                camera.set_condition(int(fields[1]))
            ray = array("i", [0, 0, 0])
            inside = camera.unproject(array("i", [int(field) for field in fields[2:4]]), ray)
            assert inside == (fields[4] != ""), line
            if inside:
                assert list(ray) == [int(field) for field in fields[4:7]], line
            count += 1
    assert count > 1000


def test_there_are_no_floats():
    try:
        eval("1.5")
    except SyntaxError:
        return
    raise AssertionError("this MicroPython has floats")


for test in (test_there_are_no_floats, test_rays):
    test()
    print(test.__name__, "passed")
