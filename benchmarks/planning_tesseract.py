def urdf(arm, things):
    raise NotImplementedError


def srdf(arm):
    raise NotImplementedError
