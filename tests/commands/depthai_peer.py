"""What depthai says of calibrations: prints JSON for each camera of each file."""
import json
import sys

import depthai


def camera(handler, socket, points):
    width, height = json.loads(sys.argv[2])
    matrix = handler.getCameraIntrinsics(socket, width, height)
    model = handler.getDistortionModel(socket)
    coefficients = handler.getDistortionCoefficients(socket)
    lens = depthai.ImgTransformation(width, height, matrix, model, coefficients)
    seen = [lens.project3DPoint(depthai.Point3f(*point)) for point in points]
    return {"matrix": matrix, "model": model.name, "coefficients": coefficients,
            "seen": [(point.x, point.y) for point in seen]}


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        points = json.load(file)
    told = []
    for path in sys.argv[3:]:
        handler = depthai.CalibrationHandler(path)
        with open(path, encoding="utf-8") as file:
            sockets = [depthai.CameraBoardSocket(socket) for socket, _ in
                       json.load(file)["cameraData"]]
        first = sockets[0]
        told.append({
            "cameras": {socket.name: camera(handler, socket, points) for socket in sockets},
            "to_first": {socket.name: handler.getCameraExtrinsics(socket, first)
                         for socket in sockets[1:]},
            "from_first_m": {socket.name: handler.getCameraTranslationVector(
                first, socket, unit=depthai.LengthUnit.METER) for socket in sockets[1:]}})
    # depthai writes its warnings to the standard output.
    print("\nresult:" + json.dumps(told))


main()
